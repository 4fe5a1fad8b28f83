#include "polhode/body/inertia.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

// Turns axes p and q so that a(p, q) vanishes, and the columns of `axes` with them (Golub & Van Loan, 8.5.2).
void jacobi_rotation(Matrix3& a, Matrix3& axes, int p, int q) {
  const double ratio = (a(q, q) - a(p, p)) / (2.0 * a(p, q));
  const double t = std::copysign(1.0, ratio) / (std::abs(ratio) + std::hypot(1.0, ratio));
  const double c = 1.0 / std::hypot(1.0, t);
  const double s = c * t;
  const int r = 3 - p - q;
  const double arp = a(r, p), arq = a(r, q);
  a(p, p) -= t * a(p, q);
  a(q, q) += t * a(p, q);
  a(p, q) = a(q, p) = 0.0;
  a(r, p) = a(p, r) = c * arp - s * arq;
  a(r, q) = a(q, r) = s * arp + c * arq;
  const Vector3 axis_p = axes.col(p), axis_q = axes.col(q);
  axes.col(p) = c * axis_p - s * axis_q;
  axes.col(q) = s * axis_p + c * axis_q;
}

bool negligible(const Matrix3& a, int p, int q) {
  constexpr double eps = std::numeric_limits<double>::epsilon();
  return std::abs(a(p, q)) <= 1e-4 * eps * std::sqrt(std::abs(a(p, p))) * std::sqrt(std::abs(a(q, q)));
}

// Column k is +-column order[k], freed of the rounding of many turns; the signs give a right-handed frame with the
// largest trace.
Matrix3 nearest_right_handed(const Matrix3& axes, const std::array<int, 3>& order) {
  Matrix3 sorted;
  const Vector3 second = axes.col(order[1]);
  sorted.col(0) = axes.col(order[0]).normalized();
  sorted.col(1) = (second - sorted.col(0).dot(second) * sorted.col(0)).normalized();
  sorted.col(2) = sorted.col(0).cross(sorted.col(1));
  Matrix3 best = sorted;
  for (int kept = 0; kept < 3; ++kept) {
    Matrix3 turned = -sorted;
    turned.col(kept) = sorted.col(kept);
    if (turned.trace() > best.trace()) best = turned;
  }
  return best + Matrix3::Zero();  // no negative zeros
}

}  // namespace

void check_triangle(const Vector3& principal_moments) {
  const Vector3& moments = principal_moments;
  if (moments[2] - moments[1] > moments[0] + triangle_tolerance * moments[2]) {
    throw InputError(
        fmt::format("impossible inertia: principal moments {:.9g}, {:.9g}, {:.9g}; no moment can exceed the sum of the "
                    "other two (by more than {:g} of itself)",
                    moments[0], moments[1], moments[2], triangle_tolerance));
  }
}

void check_principal_moments(const Vector3& principal_moments) {
  const Vector3& I = principal_moments;
  if (!(kLeastMagnitude <= I[0] && I[0] <= I[1] && I[1] <= I[2] && I[2] <= kGreatestMagnitude)) {
    throw InputError(fmt::format(
        "the principal moments are {}, {}, {}; positive ones in ascending order from {:g} to {:g} are wanted", I[0],
        I[1], I[2], kLeastMagnitude, kGreatestMagnitude));
  }
  if (!(I[2] / kGreatestMomentRatio <= I[0])) {
    throw InputError(fmt::format("the principal moments are {}, {}, {}; the largest may be {:g} times the smallest",
                                 I[0], I[1], I[2], kGreatestMomentRatio));
  }
}

void check_angular_momentum(const Vector3& momentum) {
  const double length = momentum.stableNorm();
  if (momentum.isZero(0.0) || (kLeastMagnitude <= length && length <= kGreatestMagnitude)) return;
  throw InputError(fmt::format("the angular momentum is {}, {}, {}; 0, or one of a length from {:g} to {:g}, is wanted",
                               momentum[0], momentum[1], momentum[2], kLeastMagnitude, kGreatestMagnitude));
}

void check(const Inertia& inertia) {
  check_principal_moments(inertia.principal_moments);
  check_triangle(inertia.principal_moments);
  check_principal_axes(inertia.named_from_principal);
}

void check_principal_axes(const Matrix3& named_from_principal) {
  const Matrix3& R = named_from_principal;
  if (!(R.allFinite() && R.determinant() > 0.0 && (R.transpose() * R).isIdentity(1e-9))) {
    throw InputError("the principal axes are not three right-handed axes of length 1 at right angles");
  }
}

Matrix3 inertia_tensor(const Vector3& moments, const Vector3& products, ProductsOfInertia sign) {
  const Vector3 element = sign == ProductsOfInertia::tensor_elements ? products : Vector3(-products);
  Matrix3 tensor = moments.asDiagonal();
  tensor(0, 1) = tensor(1, 0) = element[0];
  tensor(0, 2) = tensor(2, 0) = element[1];
  tensor(1, 2) = tensor(2, 1) = element[2];
  return tensor;
}

Matrix3 inertia_tensor(const Inertia& inertia) {
  const Matrix3& R = inertia.named_from_principal;
  return R * inertia.principal_moments.asDiagonal() * R.transpose();
}

Inertia inertia_from_tensor(const Matrix3& tensor, bool absolute) {
  if (!tensor.allFinite()) throw InputError("the inertia holds a number that is not finite");
  const double off = (tensor - tensor.transpose()).cwiseAbs().maxCoeff();
  if (!(off <= 1e-9 * tensor.cwiseAbs().maxCoeff())) {
    throw InputError(fmt::format("the tensor is not symmetric: elements differ by {} from those across", off));
  }
  Matrix3 a = tensor.selfadjointView<Eigen::Upper>();
  Matrix3 axes = Matrix3::Identity();
  constexpr int most_sweeps = 50;  // five or six are usual
  bool diagonal = false;
  for (int sweep = 0; sweep < most_sweeps && !diagonal; ++sweep) {
    diagonal = true;
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        if (negligible(a, p, q)) continue;
        jacobi_rotation(a, axes, p, q);
        diagonal = false;
      }
    }
  }
  std::array<int, 3> order{0, 1, 2};
  std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return a(i, i) < a(j, j); });
  Inertia inertia;
  inertia.absolute = absolute;
  for (int k = 0; k < 3; ++k) {
    const int from = order[static_cast<std::size_t>(k)];
    inertia.principal_moments[k] = a(from, from);
  }
  const Vector3& moments = inertia.principal_moments;
  if (!(moments[0] > 0.0)) {
    throw InputError(fmt::format("impossible inertia: principal moments {:.9g}, {:.9g}, {:.9g}; all must be positive",
                                 moments[0], moments[1], moments[2]));
  }
  check_triangle(moments);
  inertia.named_from_principal = nearest_right_handed(axes, order);
  return inertia;
}

Inertia inertia_from_moments(const Vector3& moments_named, bool absolute) {
  return inertia_from_tensor(moments_named.asDiagonal(), absolute);
}

Vector3 equivalent_ellipsoid_ratios(const Inertia& inertia) {
  check(inertia);
  const auto [i1, i2, i3] =
      std::array{inertia.principal_moments[0], inertia.principal_moments[1], inertia.principal_moments[2]};
  const double longest = i2 - i1 + i3;  // 5 a^2 / mass, and so on
  const double flattest = std::max(0.0, i1 - (i3 - i2));
  return {1.0, std::sqrt((i1 + (i3 - i2)) / longest), std::sqrt(flattest / longest)};
}

}  // namespace polhode
