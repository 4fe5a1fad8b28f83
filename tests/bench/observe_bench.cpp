// bench_observe [INSTANTS]: what the brightness of a body costs, ns per instant or per facet and instant, in blocks
// that stay in the cache, one thread; and a year of a tumbling asteroid at one minute, as observe() gives it. The least
// of many runs.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

#include "polhode/motion/methods.hpp"
#include "polhode/observe/observation.hpp"
#include "polhode/time/scale.hpp"

namespace {

using namespace polhode;

constexpr std::size_t block = 256, stride = block + 24;

double least_ns(const std::function<void()>& work) {
  double least = std::numeric_limits<double>::infinity();
  for (int run = 0; run < 300; ++run) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    least = std::min(least, std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count());
  }
  return least;
}

/// An ellipsoid of rings and meridians: 2 meridians (rings - 1) facets.
TriangleMesh mesh_of(const Vector3& axes, std::uint32_t rings, std::uint32_t meridians) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, -axes.z()}, {0, 0, axes.z()}};
  for (std::uint32_t i = 1; i < rings; ++i) {
    const double latitude = std::numbers::pi * (static_cast<double>(i) / rings - 0.5);
    for (std::uint32_t k = 0; k < meridians; ++k) {
      const double longitude = 2.0 * std::numbers::pi * k / meridians;
      mesh.vertices.push_back(axes.cwiseProduct(Vector3(std::cos(latitude) * std::cos(longitude),
                                                        std::cos(latitude) * std::sin(longitude), std::sin(latitude))));
    }
  }
  const auto at = [=](std::uint32_t ring, std::uint32_t k) { return 2 + (ring - 1) * meridians + k % meridians; };
  for (std::uint32_t k = 0; k < meridians; ++k) {
    mesh.facets.push_back({0, at(1, k + 1), at(1, k)});
    mesh.facets.push_back({1, at(rings - 1, k), at(rings - 1, k + 1)});
    for (std::uint32_t ring = 1; ring + 1 < rings; ++ring) {
      mesh.facets.push_back({at(ring, k), at(ring, k + 1), at(ring + 1, k)});
      mesh.facets.push_back({at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)});
    }
  }
  return mesh;
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t instants = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 525'600;
  const FreeBody body{{0.64, 0.97, 1.0}, Quaternion(0.5, 0.5, 0.5, 0.5), {1e-5, 1e-6, 6.2e-5}};
  const std::shared_ptr<const Motion> motion = method("auto").make(body);
  std::vector<double> memory(30 * stride, 0.0);
  const auto array = [&](std::size_t k) { return memory.data() + k * stride; };
  for (std::size_t i = 0; i < block; ++i) {
    array(0)[i] = 3e5 + 61.7 * static_cast<double>(i);  // times
    const Vector3 observer = Vector3(1, 0.2, 0.1 + 1e-3 * static_cast<double>(i)).normalized();
    const Vector3 sun = Vector3(0.4, 1.0, -0.3).normalized();
    for (std::size_t k = 0; k < 3; ++k) {
      array(1 + k)[i] = observer[static_cast<Eigen::Index>(k)];
      array(4 + k)[i] = sun[static_cast<Eigen::Index>(k)];
    }
  }
  StateArrays states;
  for (std::size_t k = 0; k < 4; ++k) states.q[k] = array(7 + k);
  states.q_stride = 1;
  const TimeArrays times{{array(0), block}};
  const brightness::Directions inertial{{array(1), array(2), array(3)}, {array(4), array(5), array(6)}};
  const double* const q[4] = {array(7), array(8), array(9), array(10)};
  double* const observer[3] = {array(11), array(12), array(13)};
  double* const sun[3] = {array(14), array(15), array(16)};
  const brightness::Directions mapped{{observer[0], observer[1], observer[2]}, {sun[0], sun[1], sun[2]}};
  constexpr double map[9] = {0.5, 0.0, 0.0, 0.0, 0.7, 0.0, 0.0, 0.0, 1.0};
  const brightness::Kernels& kernels = brightness::best_kernels();
  const double attitude = least_ns([&] { motion->batch(times, states); }) / block;
  const double area = least_ns([&] {
                        motion->batch(times, states);
                        kernels.turn(block, q, inertial, map, observer, sun);
                        kernels.ellipsoid_area(block, mapped, 1.0, array(17));
                      }) /
                      block;
  const double scattered = least_ns([&] {
                             motion->batch(times, states);
                             kernels.turn(block, q, inertial, map, observer, sun);
                             kernels.ellipsoid_lommel_seeliger(block, mapped, 1.0, array(17));
                           }) /
                           block;
  fmt::print(
      "target={}\nattitude_ns={:.2f}\nattitude_and_ellipsoid_area_ns={:.2f}\n"
      "attitude_and_ellipsoid_lommel_seeliger_ns={:.2f}\n",
      kernels.name, attitude, area, scattered);
  const TriangleMesh mesh = mesh_of({200.0, 150.0, 130.0}, 26, 40);
  const auto shape = mesh_shape(mesh, 1.0);
  for (const char* law : {"projected-area", "lommel-seeliger", "lommel-seeliger-lambert"}) {
    const double cost = least_ns([&] { shape->shine(block, mapped, scattering_law(law), {array(17), array(18)}); });
    fmt::print("facet_{}_ns={:.3f}\n", law, cost / block / static_cast<double>(mesh.facets.size()));
  }
  const Instant epoch = parse_date("2029-01-01T00:00:00", TimeScale::tdb);
  const KeplerElements elements{1.32712440018e20, 1.11e11, 0.19, 5e6, {1.0, 0.2, 0.0}, {-0.02, 0.1, 1.0}};
  const Viewing viewing(KnownWay{Trajectory(elements), Frame::icrf, epoch, "SUN", {}}, TheGeocentre{});
  std::vector<Instant> receptions;
  for (std::size_t i = 0; i < instants; ++i) receptions.push_back(epoch + Seconds{60.0 * static_cast<double>(i), 0.0});
  ObservationOptions options;
  options.geometry = false;
  options.photometry = Photometry{shape, scattering_law("lommel-seeliger"), {}, {}};
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t processor = std::clock();
  const Sights sights(viewing, receptions);
  const auto columns = observe(
      {motion, Frame::icrf, epoch, Matrix3::Identity(), body.principal_moments}, receptions,
      [&](std::size_t, Instant reception) { return sights.at(reception); }, options);
  fmt::print("year_instants={}\nyear_s={:.3f}\nyear_processor_s={:.3f}\nchecksum={:.12g}\n", instants,
             std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(),
             static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC, columns[0].values[instants / 2]);
  return 0;
}
