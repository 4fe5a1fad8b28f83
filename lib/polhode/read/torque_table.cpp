#include "polhode/read/torque_table.hpp"

#include <fmt/format.h>

#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/body/invariants.hpp"
#include "polhode/read/mesh_file.hpp"

namespace polhode {

Vector3 TorqueTable::direction(std::string_view key) const {
  const Vector3 direction = table_.vector3(key);
  if (!(direction.norm() > 0.0)) throw table_.error(key, "found the zero vector, a direction is wanted");
  return direction.normalized();
}

int TorqueTable::choice(std::string_view key, const std::array<std::string_view, 2>& texts) const {
  const std::string found = table_.text(key);
  if (found == texts[0]) return 0;
  if (found == texts[1]) return 1;
  throw table_.error(key, fmt::format("found '{:.40}'; allowed: '{}' or '{}'", found, texts[0], texts[1]));
}

const OrbitAboutMass& TorqueTable::orbit(std::string_view key) const {
  const std::string name = table_.text(key);
  const auto found = surroundings_.orbits.find(name);
  if (found == surroundings_.orbits.end()) {
    throw table_.error(key, fmt::format("found '{:.40}', but the scene has no table [orbit.{:.40}]", name, name));
  }
  return found->second;
}

Vector3 TorqueTable::centre_of_mass(const TriangleMesh& mesh) const {
  constexpr std::string_view choices =
      "'mesh origin' (the mesh's coordinates count from the centre of mass), 'mesh centroid' (the mesh is moved to "
      "where the centre of mass of a solid of one density is), or where it is, [x, y, z] in the mesh's coordinates";
  if (!table_.has("centre_of_mass")) {
    throw table_.error("centre_of_mass", fmt::format("this key is missing; it says {}", choices));
  }
  // A body with plates is no solid.
  if (table_.is_array("centre_of_mass")) return table_.vector3("centre_of_mass");
  const std::string choice = table_.text("centre_of_mass");
  if (choice == "mesh origin" && !surfaces_are_alike(mesh)) return Vector3::Zero();
  const MassProperties solid = table_.located("mesh", [&] { return mass_properties(mesh); });  // refuses what is open
  if (choice == "mesh origin") return Vector3::Zero();
  if (choice == "mesh centroid") return solid.centre_of_mass;
  throw table_.error("centre_of_mass", fmt::format("found '{:.40}'; allowed: {}", choice, choices));
}

TriangleMesh TorqueTable::mesh_from_centre_of_mass_m() const {
  const std::string path = (surroundings_.folder / table_.file_name("mesh")).string();
  TriangleMesh mesh = read_mesh(table_.opened("mesh", [&] { return surroundings_.content_of(path); }), path);
  const double unit_m = table_.positive_number("unit_m");
  const Vector3 centre = centre_of_mass(mesh);
  for (Vector3& vertex : mesh.vertices) vertex = unit_m * (vertex - centre);
  return mesh;
}

bool TorqueTable::surfaces_are_alike(const TriangleMesh& mesh) const {
  return mesh.surface_names.empty() || table_.has("specular") || table_.has("accommodation");
}

const TomlTable& TorqueTable::surface_of(const TriangleMesh& mesh, std::size_t facet) const {
  const std::string& name = mesh.surface_names[mesh.surface_of_facet[facet]];
  const auto found = surroundings_.surfaces.find(name);
  if (found == surroundings_.surfaces.end()) {
    throw table_.error("mesh", fmt::format("facet {} has the surface '{:.40}', but the scene has no table "
                                           "[surface.{:.40}], and the torque does not say what all are like",
                                           facet + 1, name, name));
  }
  return found->second;
}

void check_surface(const TomlTable& table) {
  table.allow_only({"sides", "specular", "diffuse", "accommodation", "rebound_speed"});
  surface_has_two_sides(table);
}

bool surface_has_two_sides(const TomlTable& table) {
  if (!table.has("sides")) return false;
  const double sides = table.number("sides");
  if (sides != 1.0 && sides != 2.0) throw table.error("sides", fmt::format("found {}, 1 or 2 is wanted", sides));
  return sides == 2.0;
}

double TorqueTable::momentum() const { return momentum_principal(surroundings_.body).norm(); }

Torque read_torque(const TomlTable& table, const TorqueSurroundings& surroundings) {
  const std::string kind = table.text("kind");
  std::optional<Torque> torque;
  std::string kinds;
  for_each_torque_kind([&]<class Kind>() {
    kinds += fmt::format("{}{}", kinds.empty() ? "" : ", ", Kind::name);
    if (kind != Kind::name) return;
    std::vector<std::string_view> keys{"kind"};
    keys.insert(keys.end(), Kind::keys.begin(), Kind::keys.end());
    table.allow_only(keys);
    if (Kind::needs_absolute_inertia && !surroundings.body.inertia->absolute) {
      throw table.error("kind",
                        fmt::format("a torque of kind '{}' needs moments in kg m2, the body has ratios only", kind));
    }
    torque = Kind::read(TorqueTable(table, surroundings));
  });
  if (!torque) throw table.error("kind", fmt::format("found '{:.40}'; allowed: {}", kind, kinds));
  table.located("kind", [&] { return Torques({*torque}); });  // refuses what the torque's description excludes
  return *torque;
}

}  // namespace polhode
