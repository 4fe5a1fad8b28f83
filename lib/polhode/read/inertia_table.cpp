#include "polhode/read/inertia_table.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>

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
    throw table.error(key, fmt::format("'{}' is not an axis; allowed: x, y, z", axis));
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

// A solid of uniform density: its moments per mass, or with `mass_kg` or `density_kg_m3` in kg m2.
Inertia uniform_solid(const TomlTable& table, std::string_view form, const MassProperties& solid, double unit_m,
                      UncertainNumbers& numbers) {
  const bool has_mass = table.has("mass_kg");
  const bool has_density = table.has("density_kg_m3");
  if (has_mass && has_density) throw table.error("density_kg_m3", "either mass_kg or density_kg_m3, not both");
  double factor = unit_m * unit_m / solid.volume;  // of 1 kg
  if (has_mass || has_density) {
    const std::string_view key = has_mass ? "mass_kg" : "density_kg_m3";
    const double value = table.number(key);
    if (!(value > 0.0)) throw table.error(key, "must be positive");
    const double per_unit = factor * (has_mass ? 1.0 : solid.volume * unit_m * unit_m * unit_m);
    numbers.add(table, key, {}, {of_tensor(per_unit * solid.inertia_about_centre)});
    factor = per_unit * value;
  }
  return table.located(
      form, [&] { return inertia_from_tensor(Matrix3(factor * solid.inertia_about_centre), has_mass || has_density); });
}

/// 1 where nothing depends on the unit.
double solid_unit_m(const TomlTable& table) {
  if (!table.has("mass_kg") && !table.has("density_kg_m3") && !table.has("length_unit")) return 1.0;
  return table.parsed("length_unit", length_unit_m);
}

Inertia read_mesh_inertia(const TomlTable& table, Body& body, const BodyFileSurroundings& around) {
  table.allow_only({"mesh", "length_unit"}, {"mass_kg", "density_kg_m3"});
  const std::filesystem::path named = table.file_name("mesh");
  const std::string file =
      (named.is_absolute() ? named : std::filesystem::path(around.path).parent_path() / named).string();
  const double unit_m = solid_unit_m(table);
  const TriangleMesh mesh = read_mesh(table.opened("mesh", [&] { return around.content_of(file); }), file);
  const MassProperties solid = table.located("mesh", [&] { return mass_properties(mesh); });
  body.notes.push_back(describe(solid));
  return uniform_solid(table, "mesh", solid, unit_m, around.numbers);
}

Inertia read_ellipsoid_inertia(const TomlTable& table, UncertainNumbers& numbers) {
  table.allow_only({"length_unit"}, {"semi_axes", "mass_kg", "density_kg_m3"});
  const Vector3 axes = table.vector3("semi_axes");
  if (!(axes.minCoeff() > 0.0)) throw table.error("semi_axes", "must be positive");
  const double unit_m = solid_unit_m(table);
  const Vector3 squares = axes.cwiseProduct(axes);
  MassProperties solid;
  solid.volume = 4.0 / 3.0 * std::numbers::pi * axes.prod();
  solid.inertia_about_centre =
      Vector3(solid.volume / 5.0 * Vector3(squares[1] + squares[2], squares[0] + squares[2], squares[0] + squares[1]))
          .asDiagonal();
  const Inertia inertia = uniform_solid(table, "semi_axes", solid, unit_m, numbers);
  const Matrix3 tensor = inertia_tensor(inertia);
  const double per_square = tensor.trace() / (2.0 * squares.sum());
  std::vector<EpochChange> changes;
  for (int k = 0; k < 3; ++k) {
    Matrix3 change = Matrix3::Zero();
    for (const int other : {(k + 1) % 3, (k + 2) % 3}) change(other, other) = 2.0 * per_square * axes[k];
    if (table.has("density_kg_m3")) change += tensor / axes[k];  // the mass grows
    changes.push_back(of_tensor(change));
  }
  numbers.add(table, "semi_axes", {"x", "y", "z"}, std::move(changes));
  return inertia;
}

/// The numbers of `moments` and `products`, or `tensor`, in a unit.
void add_inertia_numbers(const TomlTable& table, double unit, double sign_of_products, UncertainNumbers& numbers) {
  constexpr std::array<std::pair<int, int>, 6> elements{{{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};
  std::vector<EpochChange> all, moments, products;
  for (const auto& [i, k] : elements) {
    all.push_back(of_tensor(symmetric_unit(i, k, unit)));
    (i == k ? moments : products).push_back(of_tensor(symmetric_unit(i, k, i == k ? unit : sign_of_products * unit)));
  }
  if (table.has("tensor")) {
    numbers.add_symmetric(table, "tensor", std::move(all));
    return;
  }
  numbers.add(table, "moments", {"x", "y", "z"}, std::move(moments));
  if (table.has("products")) numbers.add(table, "products", {"xy", "xz", "yz"}, std::move(products));
}

}  // namespace

Inertia read_inertia(const TomlTable& table, Body& body, const BodyFileSurroundings& around) {
  if (table.has("mesh")) return read_mesh_inertia(table, body, around);
  if (table.has("semi_axes")) return read_ellipsoid_inertia(table, around.numbers);
  // The last two have been asked for: they stand here for the messages.
  table.allow_only({"products_are", "unit", "long_axis", "intermediate_axis", "short_axis", "mesh", "semi_axes"},
                   {"moments", "products", "tensor"});
  const std::string_view form = table.one_of({"moments", "tensor", "mesh", "semi_axes"});
  const InertiaUnit unit = table.parsed("unit", inertia_unit);
  Matrix3 tensor;
  bool diagonal = false;
  if (form == "tensor") {
    for (const std::string_view key : {"products", "products_are"}) {
      if (table.has(key)) throw table.error(key, "goes with moments; a tensor has its products in it");
    }
    tensor = table.matrix3("tensor");
    add_inertia_numbers(table, unit.factor, 1.0, around.numbers);
    if ((tensor - tensor.transpose()).cwiseAbs().maxCoeff() > 1e-12 * tensor.cwiseAbs().maxCoeff()) {
      throw table.error("tensor", "found a matrix that is not symmetric; a tensor of inertia is");
    }
  } else {
    Vector3 products = Vector3::Zero();
    ProductsOfInertia sign = ProductsOfInertia::tensor_elements;
    diagonal = !table.has("products");
    if (!diagonal) {
      products = table.vector3("products");
      diagonal = products.isZero(0.0);
      const std::string are = table.text("products_are");
      if (are == "positive integrals") {
        sign = ProductsOfInertia::positive_integrals;
      } else if (are != "tensor elements") {
        throw table.error("products_are",
                          fmt::format("'{}' is not a sign convention; allowed: 'tensor elements' (Ixy = -integral of x "
                                      "y dm) or 'positive integrals' (Ixy = +integral of x y dm)",
                                      are));
      }
    } else if (table.has("products_are")) {
      throw table.error("products_are", "goes with products, which are not given");
    }
    tensor = inertia_tensor(table.vector3("moments"), products, sign);
    add_inertia_numbers(table, unit.factor, sign == ProductsOfInertia::tensor_elements ? 1.0 : -1.0, around.numbers);
  }
  for (const std::string_view key : {"long_axis", "intermediate_axis", "short_axis"}) {
    if (table.has(key) && !diagonal && !around.is_clone) {
      throw table.error(key, "only axes without products of inertia have these names; leave them away");
    }
  }
  const Inertia inertia =
      table.located(form, [&] { return inertia_from_tensor(Matrix3(unit.factor * tensor), unit.absolute); });
  if (!around.is_clone) check_axis_names(table, inertia);
  return inertia;
}

}  // namespace polhode
