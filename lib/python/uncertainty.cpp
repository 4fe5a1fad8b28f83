#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/motion/attitude_covariance.hpp"
#include "polhode/motion/known_until.hpp"
#include "python/objects.hpp"
#include "python/states.hpp"

namespace polhode::python {
namespace {

FloatArray matrix_array(const Eigen::MatrixXd& matrix) {
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> by_rows = matrix;
  return array_of(Shape{static_cast<std::size_t>(matrix.rows()), static_cast<std::size_t>(matrix.cols())},
                  by_rows.data());
}

/// Uncertainty: of a body's published numbers.
struct UncertaintyObject {
  std::shared_ptr<const Uncertainty> uncertainty;
};

std::optional<UncertaintyObject> uncertainty_of_body(const BodyObject& self) {
  if (!self.body().uncertainty) return std::nullopt;
  return UncertaintyObject{self.body().uncertainty};
}

/// Covariances of the attitude at t, (..., 3, 3).
FloatArray covariance_at(const MotionObject& self, const nb::object& t, unsigned threads) {
  if (!self.moving) throw InputError("a motion of a body with uncertainties is wanted");
  const Elapsed times = elapsed_of(t, self.epoch());
  Shape shape = times.scalar ? Shape{} : times.high.shape;
  const std::size_t count = count_of(shape);
  shape.insert(shape.end(), {3, 3});
  auto [array, matrices] = new_array(shape);
  {
    const nb::gil_scoped_release others_go_on;
    const std::span<const double> high = times.scalar ? std::span(&times.high_s, 1) : std::span(times.high.data, count);
    const std::span<const double> low = times.scalar ? std::span(&times.low_s, 1) : std::span(times.low);
    std::vector<double> sigma(count), six(6 * count);
    if (self.moving->under_torques) {
      const std::vector<double> zeros(low.empty() ? count : 0, 0.0);
      covariance_rows(*self.moving, 0.0, 0.0)
          .rows(high, low.empty() ? std::span(zeros) : low, sigma.data(), six.data());
    } else {
      batch_threads(AttitudeCovariance(self.moving->body), {high, low}, sigma, six, threads);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const double* c = &six[6 * i];
      const double whole[9] = {c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5]};
      std::copy_n(whole, 9, matrices + 9 * i);
    }
  }
  return {array};
}

}  // namespace

void bind_uncertainty(nb::module_& m) {
  nb::class_<UncertaintyObject>(m, "Uncertainty", "How well the published numbers of a body are known.")
      .def_prop_ro(
          "names",
          [](const UncertaintyObject& self) {
            std::vector<std::string> names;
            for (const PublishedNumber& number : self.uncertainty->numbers) names.push_back(number.name);
            return names;
          },
          "Of the numbers that are not exact, as in body files: 'components.x', 'P_phi'.")
      .def_prop_ro(
          "values",
          [](const UncertaintyObject& self) {
            const Eigen::VectorXd values = self.uncertainty->values();
            return array_of(Shape{self.uncertainty->numbers.size()}, values.data());
          },
          "As published, in the file's units, shape (n,).")
      .def_prop_ro(
          "covariance", [](const UncertaintyObject& self) { return matrix_array(self.uncertainty->covariance); },
          "Of the values, shape (n, n).")
      .def(
          "body",
          [](const UncertaintyObject& self, const Given<Numbers>& values) {
            const auto count = static_cast<Eigen::Index>(values->size());
            const Eigen::VectorXd all = Eigen::Map<const Eigen::VectorXd>(values->data, count);
            return BodyObject{{self.uncertainty->body_with(all), std::nullopt, false}, {}};
          },
          "values"_a,
          "The body with these values in the place of the published ones: a clone, if they are drawn. Raises "
          "InputError "
          "where no body has them.")
      .def("__repr__", [](const UncertaintyObject& self) {
        return fmt::format("<Uncertainty of {} numbers>", self.uncertainty->numbers.size());
      });

  nb::class_<BodyObject> body = nb::borrow<nb::class_<BodyObject>>(m.attr("Body"));
  body.def_prop_ro("uncertainty", &uncertainty_of_body, "Of its published numbers; None: they count as exact.")
      .def_prop_ro(
          "covariance", [](const BodyObject& self) { return matrix_array(epoch_covariance(self.body())); },
          "Of (theta0, m0, I) at the epoch, shape (9, 9): a small turn of the principal axes and a change of the "
          "momentum along them, both given in the named axes, and the principal moments: what Motion.partials() takes "
          "derivatives by. Raises InputError for a body without uncertainties.")
      .def(
          "known_until",
          [](const BodyObject& self, const Given<PlaneAngle>& angle) {
            if (!(angle->rad > 0.0 && std::isfinite(angle->rad))) {
              throw InputError(fmt::format("the angle is {} rad; a positive one is wanted", angle->rad));
            }
            return known_until_s(self.body(), AttitudeCovariance(self.body()), angle->rad);
          },
          "angle"_a,
          "The first second after the epoch at which one sigma of the attitude is larger than the angle (rad, or '1 "
          "deg'), by the uncertainties, without torques; inf: never. Raises InputError for a body without "
          "uncertainties.");
  nb::class_<MotionObject> motion = nb::borrow<nb::class_<MotionObject>>(m.attr("Motion"));
  motion.def("covariance", &covariance_at, "t"_a, nb::kw_only(), "threads"_a = 1U,
             nb::sig("def covariance(self, t: typing.Any, *, threads: int = 1) -> numpy.typing.NDArray[numpy.float64]"),
             "Of the attitude at t, rad^2, an array (..., 3, 3): of a small turn in body axes, to first order, by the "
             "body's uncertainties. Raises InputError for a body without.");
}

}  // namespace polhode::python
