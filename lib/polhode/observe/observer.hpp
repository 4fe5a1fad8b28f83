#pragma once

// What observe() and observe_partials() share: the instants of a block, seen.

#include <array>
#include <cmath>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "polhode/observe/aspect.hpp"
#include "polhode/observe/observation.hpp"

namespace polhode {

/// The columns of geometry, in order.
inline constexpr std::array<std::string_view, 18> kGeometry{"light_time_s",
                                                            "range_m",
                                                            "phase_deg",
                                                            "sub_observer_lon_deg",
                                                            "sub_observer_lat_deg",
                                                            "sub_solar_lon_deg",
                                                            "sub_solar_lat_deg",
                                                            "momentum_ra_deg",
                                                            "momentum_dec_deg",
                                                            "momentum_pa_deg",
                                                            "momentum_aspect_deg",
                                                            "long_axis_ra_deg",
                                                            "long_axis_dec_deg",
                                                            "long_axis_pa_deg",
                                                            "long_axis_aspect_deg",
                                                            "phi_deg",
                                                            "theta_deg",
                                                            "psi_deg"};

/// When light is looked at within an exposure: distances from its middle, and weights that sum up to 1.
struct ExposureMoments {
  std::vector<double> offsets_s, weights;
};

/// The instants that are computed together: what they need stays in the nearest cache.
inline constexpr std::size_t kObserverBlock = 256;

/// Room for one block, as the kernels want it: arrays of which no two begin at one place in a page of memory, which
/// would make loads wait for stores.
struct ObserverWork {
  std::array<double*, 4> q{};
  std::array<double*, 3> m{}, observer{}, sun{}, observer_in_shape{}, sun_in_shape{};
  double *high = nullptr, *low = nullptr, *brightness = nullptr, *area = nullptr;
  std::vector<Sight> sights = std::vector<Sight>(kObserverBlock);

  ObserverWork() {
    double* next = memory_.data();
    const auto take = [&next](double*& array) {
      array = next;
      next += kStride;
    };
    std::for_each(q.begin(), q.end(), take);
    for (auto* const group : {&m, &observer, &sun, &observer_in_shape, &sun_in_shape}) {
      std::for_each(group->begin(), group->end(), take);
    }
    for (double** const one : {&high, &low, &brightness, &area}) take(*one);
  }
  ObserverWork(const ObserverWork&) = delete;
  ObserverWork& operator=(const ObserverWork&) = delete;

 private:
  static constexpr std::size_t kStride = kObserverBlock + 24;
  std::vector<double> memory_ = std::vector<double>(23 * kStride);
};

/// A body as it is seen at given instants, in blocks of up to kObserverBlock.
class Observer {
 public:
  /// The arguments, those of observe(), are checked, and must outlive the observer.
  Observer(const ObservedMotion& body, std::span<const Instant> receptions,
           const std::function<Sight(std::size_t, Instant)>& sight_of, const ObservationOptions& options);

  const Matrix3& named_from_principal() const { return body_.named_from_principal; }
  const ObservationOptions& options() const { return options_; }
  const ExposureMoments& moments() const { return moments_; }
  std::size_t size() const { return receptions_.size(); }

  /// Sights at the receptions and states at the emissions, principal axes.
  void states(std::size_t first, std::size_t count, double offset_s, ObserverWork& work) const;
  /// The columns of geometry of a block; a place for each of them.
  void geometry(std::size_t count, const ObserverWork& work, std::span<double* const> to) const;
  /// Brightness and area of a block.
  void shine(std::size_t count, ObserverWork& work) const;
  /// Distances in au, and the phase function, in the light of a body that is then 1 au from both.
  double light_of_brightness(const Sight& sight) const;
  /// The columns magnitude and area_m2 of a block.
  void photometry(std::size_t first, std::size_t count, ObserverWork& work, std::vector<double>& magnitude,
                  std::vector<double>& area_m2) const;

 private:
  const ObservedMotion& body_;
  std::span<const Instant> receptions_;
  const std::function<Sight(std::size_t, Instant)>& sight_of_;
  const ObservationOptions& options_;
  Matrix3 inertial_from_icrf_;
  AspectFrame frame_;
  Matrix3 map_ = Matrix3::Identity();
  double zero_ = 0.0;
  ExposureMoments moments_;
};

/// Columns of `width` numbers an instant, which `fill` fills in parts: fill(first, count, work, columns), on several
/// threads.
std::vector<ObservedColumn> filled_columns(
    const Observer& observer, std::size_t width,
    const std::function<void(std::size_t first, std::size_t count, ObserverWork&, std::vector<ObservedColumn>&)>& fill);

}  // namespace polhode
