// bench_fits FOLDER [ROWS [RATIO]]: a FITS ephemeris of a tumbling body, checksum included, against the same bytes as
// constants through cfitsio, checksum included. Both take turns; the medians of five count. Exit status 1 beyond
// RATIO, 1.3.
#include <fitsio.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/motion/methods.hpp"
#include "polhode/write/fits.hpp"
#include "polhode/write/output_file.hpp"

namespace {

using polhode::Body;

struct Cost {
  double wall_s;
  double processor_s;  // of all threads: what counts on a machine with other work
};

Cost cost(const std::function<void()>& work) {
  const std::clock_t processor = std::clock();
  const auto begin = std::chrono::steady_clock::now();
  work();
  return {std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(),
          static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC};
}

Cost median(std::span<Cost> costs) {
  const auto middle = [&costs](double Cost::*part) {
    std::sort(costs.begin(), costs.end(), [part](const Cost& a, const Cost& b) { return a.*part < b.*part; });
    return costs[costs.size() / 2].*part;
  };
  return {middle(&Cost::wall_s), middle(&Cost::processor_s)};
}

/// As many bytes per row as write_fits, all alike, in blocks of the size that cfitsio likes best.
void write_constants(const std::string& path, std::size_t rows) {
  polhode::OutputFile output(path);
  fitsfile* file = nullptr;
  int status = 0;
  fits_create_diskfile(&file, output.temporary_path().c_str(), &status);
  fits_create_img(file, BYTE_IMG, 0, nullptr, &status);
  fits_write_chksum(file, &status);
  std::array<std::string, 6> text{"TIME", "QPARAM", "OMEGA", "1D", "4D", "3D"};
  std::array<char*, 3> names{text[0].data(), text[1].data(), text[2].data()};
  std::array<char*, 3> forms{text[3].data(), text[4].data(), text[5].data()};
  fits_create_tbl(file, BINARY_TBL, 0, 3, names.data(), forms.data(), nullptr, "ATTITUDE", &status);
  constexpr std::size_t row_bytes = 64;
  constexpr std::size_t block_rows = 4096;
  std::vector<unsigned char> block(block_rows * row_bytes, 0x3f);
  for (std::size_t row = 0; row < rows; row += block_rows) {
    const std::size_t count = std::min(block_rows, rows - row);
    fits_write_tblbytes(file, static_cast<LONGLONG>(row + 1), 1, static_cast<LONGLONG>(count * row_bytes), block.data(),
                        &status);
  }
  fits_write_chksum(file, &status);
  fits_close_file(file, &status);
  if (status != 0) throw polhode::FileError(fmt::format("cfitsio status {}", status));
  output.commit();
}

int bench(const std::string& folder, std::size_t rows, double allowed) {
  Body body;
  body.name = "bench";
  body.inertia = polhode::Inertia{{1.0, 3.0836, 3.235}};
  body.state = polhode::SpinState{polhode::Instant(), polhode::TimeScale::tdb, polhode::Frame::icrf,
                                  polhode::Quaternion::Identity(), polhode::Vector3(2e-5, 5e-6, 3e-6)};
  const polhode::Method& method = polhode::method("auto");
  const std::shared_ptr<const polhode::Motion> motion = method.make(polhode::free_body(body));
  const auto states = [motion](std::span<const double> high, std::span<const double> low, double* q, double* m) {
    motion->batch({high, low}, polhode::StateArrays::of_structures(q, m));
  };
  const polhode::Instant stop = body.state->epoch + polhode::Seconds{8.64e7, 0.0};
  polhode::EphemerisDescription description;
  description.object = body.name;
  description.method = method.name;
  const polhode::Ephemeris ephemeris(
      description, body, polhode::Frame::icrf,
      polhode::TimeGrid::with_count(body.state->epoch, stop, rows, polhode::TimeScale::tdb), states);
  const std::string path = folder + "/bench.fits";
  constexpr std::size_t turns = 5;
  std::array<Cost, turns> ours{};
  std::array<Cost, turns> constants{};
  for (std::size_t i = 0; i < turns; ++i) {
    constants[i] = cost([&] { write_constants(path, rows); });
    ours[i] = cost([&] { polhode::write_fits(path, ephemeris); });
  }
  ::unlink(path.c_str());
  const Cost our = median(ours);
  const Cost constant = median(constants);
  const double ratio = our.wall_s / constant.wall_s;
  fmt::print("rows={}\nephemeris_s={:.3f}\nconstants_s={:.3f}\nratio={:.3f}\n", rows, our.wall_s, constant.wall_s,
             ratio);
  fmt::print("ephemeris_processor_s={:.3f}\nconstants_processor_s={:.3f}\n", our.processor_s, constant.processor_s);
  return ratio <= allowed ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    fmt::print(stderr, "usage: bench_fits FOLDER [ROWS [RATIO]]\n");
    return 2;
  }
  try {
    constexpr std::size_t ten_million = 10'000'000;
    constexpr double allowed = 1.3;
    return bench(argv[1], argc > 2 ? std::strtoull(argv[2], nullptr, 10) : ten_million,
                 argc > 3 ? std::strtod(argv[3], nullptr) : allowed);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_fits: {}\n", error.what());
    return 3;
  }
}
