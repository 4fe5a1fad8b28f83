#include "polhode/read/inertia_table.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>
#include <span>

#include "polhode/base/error.hpp"
#include "polhode/read/mesh_file.hpp"
#include "polhode/read/units.hpp"

namespace polhode {
namespace {

EpochChange of_tensor(const Matrix3& tensor) {
  EpochChange change;
  change.tensor = tensor;
  return change;
}

Matrix3 symmetric_unit(int i, int k, double value) {
  Matrix3 matrix = Matrix3::Zero();
  matrix(i, k) = matrix(k, i) = value;
  return matrix;
}

int axis_index(const TomlTable& table, std::string_view key) {
  const std::string axis = table.text(key);
  const auto at = std::string_view("xyz").find(axis);
  if (axis.size() != 1 || at == std::string_view::npos) {
    throw table.error(key, fmt::format("'{:.60}' is not an axis; allowed: x, y, z", axis));
  }
  return static_cast<int>(at);
}

// What the file says about its axes must be what its moments say.
void check_axis_names(const TomlTable& table, const Inertia& inertia) {
  constexpr std::array<std::string_view, 3> keys{"long_axis", "intermediate_axis", "short_axis"};
  const Vector3 moments_named = inertia_tensor(inertia).diagonal();
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (!table.has(keys[k])) continue;
    const int axis = axis_index(table, keys[k]);
    const double wanted = inertia.principal_moments[static_cast<int>(k)];
    if (moments_named[axis] == wanted) continue;
    throw table.error(keys[k], fmt::format("the moment about {} is {:.9g}, but the {} of the three is {:.9g} (the long "
                                           "axis has the smallest moment, the short axis the largest)",
                                           "xyz"[axis], moments_named[axis],
                                           k == 0   ? "smallest"
                                           : k == 1 ? "middle one"
                                                    : "largest",
                                           wanted));
  }
}

/// The factor from moments of density 1 to those of the file: per mass, or with `mass_kg` or `density_kg_m3` in kg m2.
struct SolidFactor {
  std::optional<std::size_t> place;  ///< of the mass or density
  bool is_density = false;
  double unit_m = 1.0;

  double per_unit(double volume) const {
    return unit_m * unit_m / volume * (is_density ? volume * unit_m * unit_m * unit_m : 1.0);
  }
  Inertia inertia(const MassProperties& solid, std::span<const double> numbers) const {
    const double factor = per_unit(solid.volume) * (place ? numbers[*place] : 1.0);
    return inertia_from_tensor(Matrix3(factor * solid.inertia_about_centre), place.has_value());
  }
  /// What the mass or density does.
  void set_changes(const MassProperties& solid, UncertainNumbers& numbers) const {
    if (place) numbers.set_changes(*place, {of_tensor(per_unit(solid.volume) * solid.inertia_about_centre)});
  }
};

SolidFactor read_solid_factor(const TomlTable& table, UncertainNumbers& numbers) {
  SolidFactor out;
  const bool has_mass = table.has("mass_kg");
  out.is_density = table.has("density_kg_m3");
  if (has_mass && out.is_density) throw table.error("density_kg_m3", "either mass_kg or density_kg_m3, not both");
  if (has_mass || out.is_density || table.has("length_unit")) out.unit_m = table.parsed("length_unit", length_unit_m);
  if (has_mass || out.is_density) {
    const std::string_view key = has_mass ? "mass_kg" : "density_kg_m3";
    if (!(table.number(key) > 0.0)) throw table.error(key, "must be positive");
    out.place = numbers.add(table, key);
  }
  return out;
}

void read_mesh_inertia(const TomlTable& table, Body& body, const BodyFileSurroundings& around) {
  table.allow_only({"mesh", "length_unit"}, {"mass_kg", "density_kg_m3"});
  const std::filesystem::path named = table.file_name("mesh");
  const std::string file =
      (named.is_absolute() ? named : std::filesystem::path(around.path).parent_path() / named).string();
  const SolidFactor factor = read_solid_factor(table, around.numbers);
  const TriangleMesh mesh = read_mesh(table.opened("mesh", [&] { return around.content_of(file); }), file);
  const MassProperties solid = table.located("mesh", [&] { return mass_properties(mesh); });
  body.notes.push_back(describe(solid));
  factor.set_changes(solid, around.numbers);
  table.located("mesh", [&] {
    around.numbers.make(body, [factor, solid](std::span<const double> numbers, Body& made) {
      made.inertia = factor.inertia(solid, numbers);
    });
  });
}

MassProperties ellipsoid(const Vector3& axes) {
  if (!(axes.minCoeff() > 0.0)) throw InputError("must be positive");
  const Vector3 squares = axes.cwiseProduct(axes);
  MassProperties solid;
  solid.volume = 4.0 / 3.0 * std::numbers::pi * axes.prod();
  solid.inertia_about_centre =
      Vector3(solid.volume / 5.0 * Vector3(squares[1] + squares[2], squares[0] + squares[2], squares[0] + squares[1]))
          .asDiagonal();
  return solid;
}

void read_ellipsoid_inertia(const TomlTable& table, Body& body, UncertainNumbers& numbers) {
  table.allow_only({"length_unit"}, {"semi_axes", "mass_kg", "density_kg_m3"});
  const Vector3 axes = table.vector3("semi_axes");
  const MassProperties solid = table.located("semi_axes", [&] { return ellipsoid(axes); });
  const SolidFactor factor = read_solid_factor(table, numbers);
  const std::size_t place = numbers.add(table, "semi_axes", {"x", "y", "z"});
  factor.set_changes(solid, numbers);
  table.located("semi_axes", [&] {
    numbers.make(body, [factor, place](std::span<const double> others, Body& made) {
      made.inertia = factor.inertia(ellipsoid(Vector3(&others[place])), others);
    });
  });
  const Matrix3 tensor = inertia_tensor(*body.inertia);
  const double per_square = tensor.trace() / (2.0 * axes.squaredNorm());
  std::vector<EpochChange> changes;
  for (int k = 0; k < 3; ++k) {
    Matrix3 change = Matrix3::Zero();
    for (const int other : {(k + 1) % 3, (k + 2) % 3}) change(other, other) = 2.0 * per_square * axes[k];
    if (table.has("density_kg_m3")) change += tensor / axes[k];  // the mass grows
    changes.push_back(of_tensor(change));
  }
  numbers.set_changes(place, std::move(changes));
}

/// What the elements of a tensor do, in a unit: xx, xy, xz, yy, yz, zz.
std::vector<EpochChange> changes_of_tensor(double unit) {
  std::vector<EpochChange> changes;
  for (int i = 0; i < 3; ++i) {
    for (int k = i; k < 3; ++k) changes.push_back(of_tensor(symmetric_unit(i, k, unit)));
  }
  return changes;
}

ProductsOfInertia products_are(const TomlTable& table) {
  const std::string are = table.text("products_are");
  if (are == "positive integrals") return ProductsOfInertia::positive_integrals;
  if (are == "tensor elements") return ProductsOfInertia::tensor_elements;
  throw table.error("products_are",
                    fmt::format("'{:.60}' is not a sign convention; allowed: 'tensor elements' (Ixy = -integral of x y "
                                "dm) or 'positive integrals' (Ixy = +integral of x y dm)",
                                are));
}

void read_tensor(const TomlTable& table, const InertiaUnit& unit, Body& body, UncertainNumbers& numbers) {
  for (const std::string_view key : {"products", "products_are"}) {
    if (table.has(key)) throw table.error(key, "goes with moments; a tensor has its products in it");
  }
  const Matrix3 tensor = table.matrix3("tensor");
  const std::size_t place = numbers.add_symmetric(table, "tensor");
  if ((tensor - tensor.transpose()).cwiseAbs().maxCoeff() > 1e-12 * tensor.cwiseAbs().maxCoeff()) {
    throw table.error("tensor", "found a matrix that is not symmetric; a tensor of inertia is");
  }
  numbers.set_changes(place, changes_of_tensor(unit.factor));
  table.located("tensor", [&] {
    numbers.make(body, [unit, place](std::span<const double> others, Body& made) {
      const double* const t = &others[place];  // xx, xy, xz, yy, yz, zz
      Matrix3 full;
      full << t[0], t[1], t[2], t[1], t[3], t[4], t[2], t[4], t[5];
      made.inertia = inertia_from_tensor(Matrix3(unit.factor * full), unit.absolute);
    });
  });
}

void read_moments(const TomlTable& table, const InertiaUnit& unit, Body& body, UncertainNumbers& numbers) {
  const bool has_products = table.has("products");
  if (!has_products && table.has("products_are")) {
    throw table.error("products_are", "goes with products, which are not given");
  }
  const ProductsOfInertia sign = has_products ? products_are(table) : ProductsOfInertia::tensor_elements;
  const std::size_t place = numbers.add(table, "moments", {"x", "y", "z"});
  if (has_products) numbers.add(table, "products", {"xy", "xz", "yz"});
  std::vector<EpochChange> changes;
  changes.reserve(6);
  const double of_products = sign == ProductsOfInertia::tensor_elements ? unit.factor : -unit.factor;
  for (int k = 0; k < 3; ++k) changes.push_back(of_tensor(symmetric_unit(k, k, unit.factor)));
  for (int k = 0; has_products && k < 3; ++k) {
    changes.push_back(of_tensor(symmetric_unit(k / 2, k == 0 ? 1 : 2, of_products)));
  }
  numbers.set_changes(place, std::move(changes));
  table.located("moments", [&] {
    numbers.make(body, [unit, sign, place, has_products](std::span<const double> others, Body& made) {
      const Vector3 products = has_products ? Vector3(&others[place + 3]) : Vector3(Vector3::Zero());
      made.inertia = inertia_from_tensor(Matrix3(unit.factor * inertia_tensor(Vector3(&others[place]), products, sign)),
                                         unit.absolute);
    });
  });
}

}  // namespace

void read_inertia(const TomlTable& table, Body& body, const BodyFileSurroundings& around) {
  if (table.has("mesh")) return read_mesh_inertia(table, body, around);
  if (table.has("semi_axes")) return read_ellipsoid_inertia(table, body, around.numbers);
  // The last two have been asked for: they stand here for the messages.
  table.allow_only({"products_are", "unit", "long_axis", "intermediate_axis", "short_axis", "mesh", "semi_axes"},
                   {"moments", "products", "tensor"});
  const std::string_view form = table.one_of({"moments", "tensor", "mesh", "semi_axes"});
  const InertiaUnit unit = table.parsed("unit", inertia_unit);
  const bool diagonal = form == "moments" && (!table.has("products") || table.vector3("products").isZero(0.0));
  if (form == "tensor") {
    read_tensor(table, unit, body, around.numbers);
  } else {
    read_moments(table, unit, body, around.numbers);
  }
  for (const std::string_view key : {"long_axis", "intermediate_axis", "short_axis"}) {
    if (table.has(key) && !diagonal) {
      throw table.error(key, "only axes without products of inertia have these names; leave them away");
    }
  }
  check_axis_names(table, *body.inertia);
}

}  // namespace polhode
