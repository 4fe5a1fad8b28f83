#include "polhode/torque/facet_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace polhode {
namespace {

constexpr double kMargin = 1e-14;  // of n . s at the edge of a cell: roundings do not decide

/// The face's own direction, and those of its two coordinates.
struct Face {
  int axis, u, v;
  double sign;
};
constexpr Face face_of(int i) { return {i / 2, (i / 2 + 1) % 3, (i / 2 + 2) % 3, i % 2 == 0 ? 1.0 : -1.0}; }

void add_to(std::array<double, 27>& c, const FacetNormal& one) {
  // -(n . s) (A x s + (n . s) S + L)
  const Vector3& n = one.normal;
  for (int k = 0; k < 3; ++k) {
    double* row = &c[9U * static_cast<std::size_t>(k)];
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    // (A x s)_k = A_i s_j - A_j s_i
    double cross[3] = {0.0, 0.0, 0.0};
    cross[j] = one.along_m3[i], cross[i] = -one.along_m3[j];
    const double square = one.square_m3[k];
    for (int p = 0; p < 3; ++p) row[p] -= one.linear_m3[k] * n[p];
    for (int p = 0; p < 3; ++p) row[3 + p] -= n[p] * (cross[p] + square * n[p]);
    for (int p = 0; p < 3; ++p) {
      const int q = (p + 1) % 3;
      row[6 + p] -= n[p] * cross[q] + n[q] * cross[p] + 2.0 * square * n[p] * n[q];
    }
  }
}

}  // namespace

std::size_t FacetTable::cells_along(std::size_t normals) {
  std::size_t along = 4;
  // Six facets summed one by one cost about as much as the polynomial.
  while (1.2 * static_cast<double>(normals) / static_cast<double>(along) > 6.0 &&
         24 * along * along * (sizeof(Cell) + sizeof(std::uint32_t) * normals / along) <= kMostBytes) {
    along *= 2;
  }
  return along;
}

double FacetTable::cost(std::size_t normals) {
  const double along = static_cast<double>(cells_along(normals));
  return 30.0 * along + 60.0 * along * along / static_cast<double>(normals);
}

/// From the face down to the cells, by quarters; every facet is looked at where its parents left it undecided.
class FacetTable::Maker {
 public:
  explicit Maker(FacetTable& table) : table_(table) {}

  void make() {
    std::vector<std::uint32_t> all(table_.normals_.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint32_t>(i);
    for (int face = 0; face < 6; ++face) divide(face, 0, 0, table_.along_, Cell{}, all);
  }

 private:
  void divide(int face, std::size_t u, std::size_t v, std::size_t width, Cell cell,
              const std::vector<std::uint32_t>& undecided) {
    const Face f = face_of(face);
    const double half = static_cast<double>(width) / static_cast<double>(table_.along_);
    const double middle_u = 2.0 * static_cast<double>(u) / static_cast<double>(table_.along_) - 1.0 + half;
    const double middle_v = 2.0 * static_cast<double>(v) / static_cast<double>(table_.along_) - 1.0 + half;
    std::vector<std::uint32_t> left;
    for (const std::uint32_t i : undecided) {
      const Vector3& n = table_.normals_[i].normal;
      const double middle = f.sign * n[f.axis] + middle_u * n[f.u] + middle_v * n[f.v];
      const double room = half * (std::abs(n[f.u]) + std::abs(n[f.v])) + kMargin;
      if (middle > room) {
        add_to(cell.coefficients, table_.normals_[i]);
      } else if (middle >= -room) {
        left.push_back(i);
      }
    }
    if (width > 1) {
      const std::size_t w = width / 2;
      for (const std::size_t du : {std::size_t{0}, w}) {
        for (const std::size_t dv : {std::size_t{0}, w}) divide(face, u + du, v + dv, w, cell, left);
      }
      return;
    }
    cell.first = static_cast<std::uint32_t>(table_.edge_on_.size());
    table_.edge_on_.insert(table_.edge_on_.end(), left.begin(), left.end());
    cell.end = static_cast<std::uint32_t>(table_.edge_on_.size());
    table_.cells_[(static_cast<std::size_t>(face) * table_.along_ + u) * table_.along_ + v] = cell;
  }

  FacetTable& table_;
};

FacetTable::FacetTable(const std::vector<FacetNormal>& normals)
    : normals_(normals), along_(cells_along(normals.size())), cells_(6 * along_ * along_) {
  Maker(*this).make();
  for (const FacetNormal& one : normals_) {
    largest_error_m3_ += one.along_m3.norm() + one.square_m3.norm() + one.linear_m3.norm();
  }
  largest_error_m3_ *= 16.0 * std::numeric_limits<double>::epsilon();
}

Vector3 FacetTable::torque_m3(const Vector3& s) const {
  const double x = std::abs(s[0]), y = std::abs(s[1]), z = std::abs(s[2]);
  const int axis = x >= y && x >= z ? 0 : (y >= z ? 1 : 2);
  const int face = 2 * axis + (s[axis] < 0.0);
  const Face f = face_of(face);
  const double cells = static_cast<double>(along_), scale = 0.5 * cells / std::abs(s[axis]);
  const auto place = [&](int i) {
    return static_cast<std::size_t>(std::clamp(s[i] * scale + 0.5 * cells, 0.0, cells - 1.0));
  };
  const Cell& cell = cells_[(static_cast<std::size_t>(face) * along_ + place(f.u)) * along_ + place(f.v)];
  const double terms[9] = {s[0],        s[1],        s[2],        s[0] * s[0], s[1] * s[1],
                           s[2] * s[2], s[0] * s[1], s[1] * s[2], s[2] * s[0]};
  double sums[3];
  for (std::size_t k = 0; k < 3; ++k) {
    const double* row = &cell.coefficients[9 * k];
    double a = row[0] * terms[0], b = row[1] * terms[1], c = row[2] * terms[2];
    for (std::size_t i = 3; i < 9; i += 3) {
      a += row[i] * terms[i], b += row[i + 1] * terms[i + 1], c += row[i + 2] * terms[i + 2];
    }
    sums[k] = a + b + c;
  }
  double along[3] = {}, rest[3] = {};
  for (std::uint32_t i = cell.first; i < cell.end; ++i) {
    const FacetNormal& one = normals_[edge_on_[i]];
    const double seen = one.normal[0] * s[0] + one.normal[1] * s[1] + one.normal[2] * s[2];
    const double cosine = seen > 0.0 ? seen : 0.0;
    for (int k = 0; k < 3; ++k) {
      along[k] += cosine * one.along_m3[k];
      rest[k] += cosine * (cosine * one.square_m3[k] + one.linear_m3[k]);
    }
  }
  return Vector3(sums[0] - rest[0], sums[1] - rest[1], sums[2] - rest[2]) -
         Vector3(along[0], along[1], along[2]).cross(s);
}

FacetSum::FacetSum(const std::vector<FacetNormal>& normals) : fours_((normals.size() + 3) / 4) {
  for (Four& four : fours_) {
    for (int k = 0; k < 3; ++k) {
      four.normal[k] = four.along_m3[k] = four.square_m3[k] = four.linear_m3[k] = Eigen::Array4d::Zero();
    }
  }
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const auto lane = static_cast<Eigen::Index>(i % 4);
    Four& four = fours_[i / 4];
    for (int k = 0; k < 3; ++k) {
      four.normal[k][lane] = normals[i].normal[k];
      four.along_m3[k][lane] = normals[i].along_m3[k];
      four.square_m3[k][lane] = normals[i].square_m3[k];
      four.linear_m3[k][lane] = normals[i].linear_m3[k];
    }
  }
}

Vector3 FacetSum::torque_m3(const Vector3& s) const {
  Eigen::Array4d along[3], rest[3];
  for (int k = 0; k < 3; ++k) along[k] = rest[k] = Eigen::Array4d::Zero();
  for (const Four& four : fours_) {
    const Eigen::Array4d cosine = (four.normal[0] * s[0] + four.normal[1] * s[1] + four.normal[2] * s[2]).max(0.0);
    for (int k = 0; k < 3; ++k) {
      along[k] += cosine * four.along_m3[k];
      rest[k] += cosine * (cosine * four.square_m3[k] + four.linear_m3[k]);
    }
  }
  return -Vector3(along[0].sum(), along[1].sum(), along[2].sum()).cross(s) -
         Vector3(rest[0].sum(), rest[1].sum(), rest[2].sum());
}

}  // namespace polhode
