#include "polhode/body/mesh_inertia.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

using Facet = std::array<std::uint32_t, 3>;

/// Joins corners of equal coordinates and drops facets that have two equal corners. `number` keeps each remaining
/// facet's place in the file, for messages.
struct Welded {
  std::vector<Vector3> vertices;
  std::vector<Facet> facets;
  std::vector<std::size_t> number;
};

Welded weld(const TriangleMesh& mesh) {
  const std::size_t n = mesh.vertices.size();
  if (n > std::numeric_limits<std::uint32_t>::max()) throw InputError("the mesh has more than 2^32 vertices");
  for (std::size_t i = 0; i < n; ++i) {
    if (!mesh.vertices[i].allFinite()) throw InputError(fmt::format("vertex {} is not finite", i + 1));
  }
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0U);
  const auto less = [&](std::uint32_t a, std::uint32_t b) {
    const Vector3& u = mesh.vertices[a];
    const Vector3& v = mesh.vertices[b];
    return std::lexicographical_compare(u.data(), u.data() + 3, v.data(), v.data() + 3);
  };
  std::sort(order.begin(), order.end(), less);
  Welded out;
  std::vector<std::uint32_t> joined(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (i == 0 || less(order[i - 1], order[i])) out.vertices.push_back(mesh.vertices[order[i]]);
    joined[order[i]] = static_cast<std::uint32_t>(out.vertices.size() - 1);
  }
  for (std::size_t i = 0; i < mesh.facets.size(); ++i) {
    Facet f{};
    for (std::size_t k = 0; k < 3; ++k) {
      if (mesh.facets[i][k] >= n) {
        throw InputError(fmt::format("facet {} names vertex {}, but there are {}", i + 1, mesh.facets[i][k] + 1ULL, n));
      }
      f[k] = joined[mesh.facets[i][k]];
    }
    if (f[0] == f[1] || f[1] == f[2] || f[2] == f[0]) continue;
    out.facets.push_back(f);
    out.number.push_back(i + 1);
  }
  if (out.facets.size() < 4) {
    throw InputError(
        fmt::format("{} facets with three different corners; a closed surface has at least 4", out.facets.size()));
  }
  return out;
}

/// Checks that each edge joins exactly two facets that run through it in opposite directions, and returns the shell
/// (connected surface) of each facet, numbered from 0.
std::vector<std::size_t> check_edges(const Welded& mesh, std::size_t& shells) {
  struct Edge {
    std::uint64_t ends;  // smaller corner, larger corner
    std::uint32_t facet;
    bool forward;  // from the smaller to the larger
  };
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.facets.size());
  for (std::size_t i = 0; i < mesh.facets.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = mesh.facets[i][k];
      const std::uint64_t b = mesh.facets[i][(k + 1) % 3];
      edges.push_back({a < b ? (a << 32U) | b : (b << 32U) | a, static_cast<std::uint32_t>(i), a < b});
    }
  }
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return a.ends != b.ends ? a.ends < b.ends : a.facet < b.facet; });

  std::vector<std::uint32_t> parent(mesh.facets.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::size_t first = 0; first < edges.size();) {
    std::size_t last = first + 1;
    while (last < edges.size() && edges[last].ends == edges[first].ends) ++last;
    const std::size_t facet = mesh.number[edges[first].facet];
    if (last - first == 1)
      throw InputError(fmt::format("the surface is open: no facet joins an edge of facet {}", facet));
    if (last - first > 2) {
      throw InputError(
          fmt::format("the surface is not a manifold: {} facets share an edge of facet {}", last - first, facet));
    }
    if (edges[first].forward == edges[first + 1].forward) {
      throw InputError(fmt::format("facets {} and {} are neighbours of opposite orientation (one is inside out)", facet,
                                   mesh.number[edges[first + 1].facet]));
    }
    parent[root(edges[first].facet)] = root(edges[first + 1].facet);
    first = last;
  }
  std::vector<std::size_t> shell(mesh.facets.size());
  std::vector<std::size_t> of_root(mesh.facets.size(), mesh.facets.size());
  shells = 0;
  for (std::uint32_t i = 0; i < mesh.facets.size(); ++i) {
    std::size_t& id = of_root[root(i)];
    if (id == mesh.facets.size()) id = shells++;
    shell[i] = id;
  }
  return shell;
}

/// Neumaier's compensated sum.
class Sum {
 public:
  void add(double x) {
    const double s = sum_ + x;
    lost_ += std::abs(sum_) >= std::abs(x) ? (sum_ - s) + x : (x - s) + sum_;
    sum_ = s;
  }
  double value() const { return sum_ + lost_; }

 private:
  double sum_ = 0.0;
  double lost_ = 0.0;
};

/// Six times the signed volume of the tetrahedron (0, a, b, c).
double six_volumes(const Vector3& a, const Vector3& b, const Vector3& c) { return a.dot(b.cross(c)); }

/// +1 or -1: the side of the plane through a, b, c on which d lies; 0 when rounding leaves it open.
int side(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  const Vector3 u = b - a;
  const Vector3 v = c - a;
  const Vector3 w = d - a;
  const double determinant = w.dot(u.cross(v));
  const double size = w.cwiseAbs().dot(Vector3(std::abs(u[1] * v[2]) + std::abs(u[2] * v[1]),
                                               std::abs(u[2] * v[0]) + std::abs(u[0] * v[2]),
                                               std::abs(u[0] * v[1]) + std::abs(u[1] * v[0])));
  // Shewchuk's bound for the determinant of rounded differences is below 8 eps; 1e-13 also forgives surfaces that
  // merely touch after their coordinates were rounded.
  const double bound = 1e-13 * size;
  return determinant > bound ? 1 : (determinant < -bound ? -1 : 0);
}

/// Whether the segment p-q passes through the inside of the triangle a, b, c beyond doubt.
bool pierces(const Vector3& p, const Vector3& q, const Vector3& a, const Vector3& b, const Vector3& c) {
  const int sp = side(a, b, c, p);
  if (sp == 0 || side(a, b, c, q) != -sp) return false;
  const int s = side(p, q, a, b);
  return s != 0 && side(p, q, b, c) == s && side(p, q, c, a) == s;
}

/// A tree of boxes over the facets, to find pairs whose boxes meet.
class BoxTree {
 public:
  explicit BoxTree(const Welded& mesh) : mesh_(mesh), order_(mesh.facets.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
    centre_.reserve(order_.size());
    for (const Facet& f : mesh.facets) {
      centre_.push_back(mesh.vertices[f[0]] + mesh.vertices[f[1]] + mesh.vertices[f[2]]);
    }
    nodes_.reserve(order_.size());
    build(0, static_cast<std::uint32_t>(order_.size()));
  }

  struct Box {
    Eigen::Array3d low = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity());
    Eigen::Array3d high = Eigen::Array3d::Constant(-std::numeric_limits<double>::infinity());
    void add(const Eigen::Array3d& x) {
      low = low.min(x);
      high = high.max(x);
    }
    bool meets(const Box& o) const { return (low <= o.high).all() && (o.low <= high).all(); }
  };

  Box box(std::uint32_t facet) const {
    Box b;
    for (const std::uint32_t v : mesh_.facets[facet]) b.add(mesh_.vertices[v].array());
    return b;
  }

  /// Calls visit(facet) for every facet whose box meets `query`, in no order, until it returns true.
  template <typename Visit>
  bool any(const Box& query, const Visit& visit) const {
    std::array<std::uint32_t, 64> stack{};  // depth is log2 of at most 2^32 facets
    std::size_t top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const Node& node = nodes_[stack[--top]];
      if (!node.box.meets(query)) continue;
      if (node.right == 0) {
        for (std::uint32_t i = node.first; i < node.last; ++i) {
          if (visit(order_[i])) return true;
        }
      } else {
        stack[top++] = node.right;
        stack[top++] = static_cast<std::uint32_t>(&node - nodes_.data()) + 1;
      }
    }
    return false;
  }

  const std::vector<std::uint32_t>& order() const { return order_; }

 private:
  struct Node {
    Box box;
    std::uint32_t first = 0;
    std::uint32_t last = 0;
    std::uint32_t right = 0;  // 0: a leaf; the left child follows its parent
  };

  std::uint32_t build(std::uint32_t first, std::uint32_t last) {
    const auto self = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    Box bounds;
    Box centres;
    for (std::uint32_t i = first; i < last; ++i) {
      const Box b = box(order_[i]);
      bounds.add(b.low);
      bounds.add(b.high);
      centres.add(centre_[order_[i]].array());
    }
    nodes_[self].box = bounds;
    nodes_[self].first = first;
    nodes_[self].last = last;
    if (last - first <= 4) return self;
    Eigen::Index axis = 0;
    (centres.high - centres.low).maxCoeff(&axis);
    const std::uint32_t middle = first + (last - first) / 2;
    std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                     [&](std::uint32_t a, std::uint32_t b) { return centre_[a][axis] < centre_[b][axis]; });
    build(first, middle);
    const std::uint32_t right = build(middle, last);
    nodes_[self].right = right;
    return self;
  }

  const Welded& mesh_;
  std::vector<std::uint32_t> order_;
  std::vector<Vector3> centre_;
  std::vector<Node> nodes_;
};

void check_crossings(const Welded& mesh, const BoxTree& tree) {
  for (const std::uint32_t i : tree.order()) {
    const Facet& f = mesh.facets[i];
    std::uint32_t other = 0;
    const auto crosses = [&](std::uint32_t j) {
      if (j <= i) return false;
      const Facet& g = mesh.facets[j];
      for (const std::uint32_t v : f) {
        if (v == g[0] || v == g[1] || v == g[2]) return false;
      }
      other = j;
      const auto at = [&](std::uint32_t v) -> const Vector3& { return mesh.vertices[v]; };
      for (std::size_t k = 0; k < 3; ++k) {
        if (pierces(at(f[k]), at(f[(k + 1) % 3]), at(g[0]), at(g[1]), at(g[2]))) return true;
        if (pierces(at(g[k]), at(g[(k + 1) % 3]), at(f[0]), at(f[1]), at(f[2]))) return true;
      }
      return false;
    };
    if (tree.any(tree.box(i), crosses)) {
      throw InputError(
          fmt::format("the surface crosses itself: facets {} and {} intersect", mesh.number[i], mesh.number[other]));
    }
  }
}

/// How often the shells other than `own` wind around a point, by their orientation; nothing where one passes through
/// it. Van Oosterom & Strackee 1983 (IEEE Trans. BME-30, 125), eq. 8: the solid angle of a triangle.
std::optional<double> winding(const Welded& mesh, const std::vector<std::size_t>& shell, std::size_t own,
                              const Vector3& point) {
  double half_solid_angle = 0.0;
  for (std::size_t i = 0; i < mesh.facets.size(); ++i) {
    if (shell[i] == own) continue;
    const Vector3 a = mesh.vertices[mesh.facets[i][0]] - point;
    const Vector3 b = mesh.vertices[mesh.facets[i][1]] - point;
    const Vector3 c = mesh.vertices[mesh.facets[i][2]] - point;
    const double la = a.norm();
    const double lb = b.norm();
    const double lc = c.norm();
    const double volume = six_volumes(a, b, c);
    const double rest = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    if (rest <= 0.0 && std::abs(volume) <= 1e-12 * la * lb * lc) return std::nullopt;  // within the facet
    half_solid_angle += std::atan2(volume, rest);
  }
  return std::round(half_solid_angle / 6.283185307179586);
}

/// A solid's boundary winds 0 times around its outside and once around its inside: an outer shell stands where the
/// others wind 0 times, a cavity where they wind once.
void check_shells(const Welded& mesh, const std::vector<std::size_t>& shell, const std::vector<double>& volume) {
  constexpr std::size_t most = 100;
  if (volume.size() > most) {
    throw InputError(fmt::format("the mesh has {} separate surfaces; at most {} are allowed", volume.size(), most));
  }
  if (std::all_of(volume.begin(), volume.end(), [](double v) { return v < 0.0; })) {
    throw InputError("the surface is inside out: its volume is negative (reverse the order of each facet's corners)");
  }
  if (volume.size() == 1) return;
  // Of the first facet of each shell, and of as many others as cost little, the centre and points near the corners:
  // shells that meet exactly at edges, as boxes of a CAD sheet do, cross nowhere by the rules of check_crossings.
  constexpr std::size_t most_pairs = 1'000'000;
  const std::size_t every = 1 + mesh.facets.size() * mesh.facets.size() / most_pairs;
  std::vector<bool> seen(volume.size(), false);
  for (std::size_t i = 0; i < mesh.facets.size(); ++i) {
    const std::size_t s = shell[i];
    if (seen[s] && i % every != 0) continue;
    seen[s] = true;
    const std::array<Vector3, 3> corner{mesh.vertices[mesh.facets[i][0]], mesh.vertices[mesh.facets[i][1]],
                                        mesh.vertices[mesh.facets[i][2]]};
    const Vector3 centre = (corner[0] + corner[1] + corner[2]) / 3.0;
    for (const Vector3& toward : {centre, corner[0], corner[1], corner[2]}) {
      const std::optional<double> around = winding(mesh, shell, s, 0.1 * centre + 0.9 * toward);
      if (!around) continue;  // surfaces that touch
      if (volume[s] > 0.0 && *around != 0.0) {
        throw InputError(fmt::format(
            "facet {} lies inside another closed surface of the same orientation: they overlap", mesh.number[i]));
      }
      if (volume[s] < 0.0 && *around != 1.0) {
        throw InputError(
            fmt::format("the surface that has facet {} is inside out and no cavity of another one", mesh.number[i]));
      }
    }
  }
}

}  // namespace

MassProperties mass_properties(const TriangleMesh& mesh) {
  const Welded welded = weld(mesh);
  MassProperties out;
  const std::vector<std::size_t> shell = check_edges(welded, out.shells);

  // Coordinates from the middle of the box: no cancellation when the mesh stands far from the origin. Scaled to 1 so
  // that fifth powers of a length neither overflow nor vanish.
  Eigen::Array3d low = welded.vertices[0];
  Eigen::Array3d high = low;
  for (const Vector3& v : welded.vertices) {
    low = low.min(v.array());
    high = high.max(v.array());
  }
  const Vector3 origin = (0.5 * low + 0.5 * high).matrix();
  const double scale = 0.5 * (high - low).maxCoeff();
  const double cube = scale * scale * scale;
  if (!(cube * scale * scale > 0.0) || !std::isfinite(cube * scale * scale)) {
    throw InputError(fmt::format("the mesh is {:g} across: its moments cannot be held in a double", 2.0 * scale));
  }

  std::vector<Sum> shell_volume(out.shells);
  std::array<Sum, 3> first;
  std::array<Sum, 6> second;
  for (std::size_t i = 0; i < welded.facets.size(); ++i) {
    const Vector3 a = (welded.vertices[welded.facets[i][0]] - origin) / scale;
    const Vector3 b = (welded.vertices[welded.facets[i][1]] - origin) / scale;
    const Vector3 c = (welded.vertices[welded.facets[i][2]] - origin) / scale;
    const double v6 = six_volumes(a, b, c);
    const Vector3 s = a + b + c;
    shell_volume[shell[i]].add(v6 / 6.0);
    // Moments of the tetrahedron (0, a, b, c): first v6/24 s, second v6/120 (s s' + a a' + b b' + c c').
    for (Eigen::Index k = 0; k < 3; ++k) first[static_cast<std::size_t>(k)].add(v6 / 24.0 * s[k]);
    std::size_t n = 0;
    for (Eigen::Index j = 0; j < 3; ++j) {
      for (Eigen::Index k = j; k < 3; ++k)
        second[n++].add(v6 / 120.0 * (s[j] * s[k] + a[j] * a[k] + b[j] * b[k] + c[j] * c[k]));
    }
  }
  std::vector<double> volumes;
  Sum total;
  for (const Sum& v : shell_volume) {
    volumes.push_back(v.value());
    total.add(v.value());
  }
  for (std::size_t s = 0; s < volumes.size(); ++s) {
    if (std::abs(volumes[s]) < 1e-12) throw InputError("the surface is flat: it encloses no volume");
  }
  const BoxTree tree(welded);
  check_crossings(welded, tree);
  check_shells(welded, shell, volumes);

  const double volume = total.value();
  const Vector3 centre = Vector3(first[0].value(), first[1].value(), first[2].value()) / volume;
  Matrix3 moments;
  moments << second[0].value(), second[1].value(), second[2].value(),  //
      second[1].value(), second[3].value(), second[4].value(),         //
      second[2].value(), second[4].value(), second[5].value();
  moments -= volume * centre * centre.transpose();
  out.volume = volume * cube;
  out.centre_of_mass = origin + scale * centre;
  out.inertia_about_centre = (cube * scale * scale) * (moments.trace() * Matrix3::Identity() - moments);
  out.vertices = welded.vertices.size();
  out.facets = welded.facets.size();
  return out;
}

std::string describe(const MassProperties& solid) {
  const Vector3& c = solid.centre_of_mass;
  return fmt::format(
      "uniform solid of {} vertices, {} facets, {} closed surface{}: volume {:.7g}, centre of mass {:.6g}, {:.6g}, "
      "{:.6g} "
      "(the file's unit of length, its axes)",
      solid.vertices, solid.facets, solid.shells, solid.shells == 1 ? "" : "s", solid.volume, c[0], c[1], c[2]);
}

}  // namespace polhode
