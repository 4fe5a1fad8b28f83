#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "polhode/body/body.hpp"
#include "polhode/body/mesh_inertia.hpp"
#include "polhode/read/text_file.hpp"
#include "polhode/read/toml_table.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {

/// How a body moves about a mass.
struct OrbitAboutMass {
  double mu_m3_s2;
  Trajectory trajectory;
};
using OrbitsByName = std::map<std::string, OrbitAboutMass, std::less<>>;

/// The tables [surface.NAME] of a scene: numbers that torques on facets ask for, and perhaps `sides`.
using SurfacesByName = std::map<std::string, TomlTable, std::less<>>;
/// Refuses a table that is none.
void check_surface(const TomlTable& table);
/// 1 or 2; 1 if it does not say.
bool surface_has_two_sides(const TomlTable& table);

/// What the torques of a scene refer to.
struct TorqueSurroundings {
  const Body& body;  ///< with an inertia and a state
  const OrbitsByName& orbits;
  const SurfacesByName& surfaces;
  std::filesystem::path folder;  ///< where the files that a torque names are looked for
  const ContentOf& content_of;
};

/// A [[torque]] table of a scene, as the kinds of torques read themselves from it. Every failure is an InputError with
/// file, line and key.
class TorqueTable {
 public:
  TorqueTable(const TomlTable& table, const TorqueSurroundings& surroundings)
      : table_(table), surroundings_(surroundings) {}

  double number(std::string_view key) const { return table_.number(key); }
  double positive_number(std::string_view key) const { return table_.positive_number(key); }
  Vector3 vector3(std::string_view key) const { return table_.vector3(key); }
  Matrix3 matrix3(std::string_view key) const { return table_.matrix3(key); }
  /// A vector that is not 0, made unit.
  Vector3 direction(std::string_view key) const;
  /// Which of two texts it is.
  int choice(std::string_view key, const std::array<std::string_view, 2>& texts) const;

  bool has(std::string_view key) const { return table_.has(key); }

  /// The orbit that this key names.
  const OrbitAboutMass& orbit(std::string_view key = "orbit") const;
  /// The facets of the mesh that the key `mesh` names, in units of the key `unit_m`, from where the key
  /// `centre_of_mass` has the body's centre of mass: a torque on them is about it, and a mesh alone does not know.
  /// `rebound` makes a Rebound of the numbers of a surface: those of this table, or if the mesh has named surfaces,
  /// those of the scene's table of that name.
  template <class ReboundOf>
  std::vector<Facet> facets(const ReboundOf& rebound) const {
    const TriangleMesh mesh = mesh_from_centre_of_mass_m();
    if (surfaces_are_alike(mesh)) {
      const Rebound of_all = rebound(table_);
      return table_.located("mesh", [&] { return facets_of(mesh, of_all); });
    }
    std::vector<Facet> all;
    for (std::size_t i = 0; i < mesh.facets.size(); ++i) {
      const TomlTable& surface = surface_of(mesh, i);
      const Rebound of_one = rebound(surface);
      const Facet facet = table_.located("mesh", [&] { return facet_of(mesh, i, of_one); });
      all.push_back(facet);
      if (surface_has_two_sides(surface)) all.push_back(other_side(facet));
    }
    return all;
  }

  /// Of the body: principal moments, and the length of the momentum at its epoch.
  const Vector3& moments() const { return surroundings_.body.inertia->principal_moments; }
  double momentum() const;

  template <class Work>
  auto located(std::string_view key, const Work& work) const {
    return table_.located(key, work);
  }

 private:
  TriangleMesh mesh_from_centre_of_mass_m() const;
  Vector3 centre_of_mass(const TriangleMesh& mesh) const;
  bool surfaces_are_alike(const TriangleMesh& mesh) const;
  const TomlTable& surface_of(const TriangleMesh& mesh, std::size_t facet) const;

  const TomlTable& table_;
  const TorqueSurroundings& surroundings_;
};

/// The torque of a table, of the kind that its key `kind` names.
Torque read_torque(const TomlTable& table, const TorqueSurroundings& surroundings);

}  // namespace polhode
