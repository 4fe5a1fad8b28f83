#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polhode/session/body_in_motion.hpp"
#include "polhode/session/sample_statistics.hpp"
#include "polhode/write/number_table.hpp"

namespace polhode {

/// A published number that is not known at all, within `width` (a turn, in its unit) about its value.
struct UniformNumber {
  std::string name;
  double width = 0.0;
};

/// Bodies drawn from the uncertainties of one. Clone n is a function of the seed and n alone: random numbers come from
/// Philox4x32-10 with the seed as its key and n in its counter. Draws that no body can have (as negative moments) are
/// drawn again.
class CloneSource {
 public:
  /// Throws InputError where nothing is uncertain, for an unknown name, or a width that is not positive.
  CloneSource(const BodyInMotion& moving, std::uint64_t seed, std::span<const UniformNumber> uniform = {});

  struct Clone {
    FreeBody body;
    Eigen::VectorXd numbers;  ///< of which it was made: those of the body's uncertainty
  };
  Clone clone(std::uint64_t number) const;
  Clone published() const { return {published_, values_}; }

 private:
  Frame frame_;
  std::uint64_t seed_;
  std::shared_ptr<const Uncertainty> uncertainty_;
  Eigen::VectorXd values_;  ///< as published
  Eigen::MatrixXd root_;
  std::vector<double> widths_;  ///< of each number, 0: normal
  FreeBody published_;
};

/// What a sample is of.
struct Sample {
  BodyInMotion moving;  ///< the body, and under torques how its clones move
  std::uint64_t seed = 0;
  std::uint64_t count = 0;
  std::vector<UniformNumber> uniform;
  std::vector<Instant> instants;  ///< increasing
  TimeScale scale = TimeScale::tdb;
  std::string inputs;  ///< of which the body was made: contents of files and options; parts must have the same
};

/// Clones `first` to before `last`: part `part` of `parts`, from 1.
struct SamplePart {
  std::uint64_t first = 0, last = 0;
};
SamplePart part_of_sample(std::uint64_t count, std::uint64_t part, std::uint64_t parts);

/// Statistics of clones, and which of them are in it: parts on the way, and what they are of.
struct SampleState {
  std::string identity;  ///< one line: equal where parts belong together
  std::string object, frame, scale;
  std::uint64_t seed = 0, count = 0;
  std::vector<std::string> dates;  ///< of the times
  std::vector<double> times_s;     ///< the same from the reference of a FITS table
  double reference_mjd = 0.0;
  std::vector<CloneState> published;  ///< at each time
  SamplePart part;                    ///< what it shall hold
  std::uint64_t next = 0;             ///< clones from part.first to before this are in it
  std::vector<ClonesAtTime> at;       ///< each time

  std::string text() const;
  static SampleState of_text(const std::string& text);  ///< throws InputError
};

/// An empty state for a part of a sample.
SampleState empty_state(const Sample& sample, SamplePart part);

/// Called after each wave of clones, with the state so far; it may throw to stop.
using SampleProgress = std::function<void(const SampleState& state)>;

/// Goes on until all clones of the part are in the state. The result is the same bits for every thread_count and from
/// wherever it goes on, on one instruction set; those of others differ by some units in the last place of each state.
void continue_sample(const Sample& sample, SampleState& state, unsigned thread_count = 0,
                     const SampleProgress& progress = {});

/// All parts of a sample as one, in any order. Throws InputError unless they belong together, are complete and all
/// there.
SampleState joined(std::vector<SampleState> parts);

/// The statistics as a table, one row for each time.
void write_sample_statistics(const std::string& path, const SampleState& state);

/// The clones of a part as rows, times within clones.
void write_sample_rows(const std::string& path, const Sample& sample, SamplePart part, const Progress& progress = {},
                       unsigned thread_count = 0);

}  // namespace polhode
