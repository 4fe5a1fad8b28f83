#include <fmt/format.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/variant.h>

#include "polhode/base/error.hpp"
#include "polhode/body/euler.hpp"
#include "polhode/body/invariants.hpp"
#include "polhode/body/mesh_inertia.hpp"
#include "polhode/body/spin_solution.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/read/body.hpp"
#include "polhode/read/mesh_file.hpp"
#include "polhode/session/body_report.hpp"
#include "python/objects.hpp"

namespace polhode::python {
namespace {

AxisConvention convention_of(const std::string& name) {
  if (name == "long axis") return AxisConvention::long_axis;
  if (name == "short axis") return AxisConvention::short_axis;
  throw InputError(fmt::format("the convention is '{}'; 'long axis' or 'short axis' is wanted", name));
}

Inertia make_inertia(const Given<Numbers>& moments, const std::optional<Given<Numbers>>& products,
                     const std::string& sign, bool absolute) {
  if (!products) return inertia_from_moments(moments->vector3("moments"), absolute);
  if (sign != "tensor elements" && sign != "positive integrals") {
    throw InputError(fmt::format("the sign is '{}'; 'tensor elements' or 'positive integrals' is wanted", sign));
  }
  return inertia_from_tensor(inertia_tensor(moments->vector3("moments"), (*products)->vector3("products"),
                                            sign == "tensor elements" ? ProductsOfInertia::tensor_elements
                                                                      : ProductsOfInertia::positive_integrals),
                             absolute);
}

BodyObject make_body(const std::string& name, const std::optional<Inertia>& inertia,
                     const std::optional<Given<When>>& epoch, const std::string& frame,
                     const std::optional<Given<Attitude>>& q, const std::optional<Given<Rates>>& omega,
                     const std::string& source, const std::string& id, std::optional<double> period_uncertainty) {
  Body body;
  body.name = name;
  body.id = id;
  body.source = source;
  if (inertia) check(*inertia);
  body.inertia = inertia;
  if (!inertia) body.missing.emplace_back("an inertia");
  if (!epoch && (q || omega)) throw InputError("an attitude or a rate needs the epoch at which it holds");
  if (epoch) {
    SpinState state;
    state.epoch = (*epoch)->instant;
    state.frame = frame_of_state(frame);
    if (q) {
      if (!(*q)->q.coeffs().allFinite() || (*q)->q.coeffs().isZero(0.0)) {
        throw InputError("the attitude is no finite quaternion other than 0");
      }
      state.q_frame_from_named = (*q)->q.normalized();
    }
    if (omega) state.omega_named_rad_s = (*omega)->vector3("omega");
    body.state = state;
  }
  if (!epoch) body.missing.emplace_back("an epoch");
  if (!q) body.missing.emplace_back("an attitude at the epoch");
  if (!omega) body.missing.emplace_back("an angular velocity at the epoch");
  if (period_uncertainty) set_period_uncertainty(body, *period_uncertainty);
  return {{std::move(body), std::nullopt, false}, {}};
}

nb::object info(const BodyAndHistory& file, const std::string& path) {
  return from_json(json_text(report_on(path, file)));
}

template <class Object>
std::optional<FloatArray> q_of(const Object& self) {
  const auto& state = self.body().state;
  if (!state || !state->q_frame_from_named) return std::nullopt;
  return array_of(*state->q_frame_from_named);
}

std::variant<SceneObject, HistoryObject, BodyObject> read(const Given<FileName>& name) {
  const std::string path = name->path;
  auto input = [&] {
    const nb::gil_scoped_release others_go_on;
    return read_scene_or_body(path);
  }();
  if (auto* scene = std::get_if<Scene>(&input)) return SceneObject{std::move(*scene), path};
  auto& file = std::get<BodyAndHistory>(input);
  // A complete body moves as it is; else what is known of its attitude is the history.
  if (file.history && (file.is_table || !file.body.missing.empty())) return HistoryObject{std::move(file), path};
  return BodyObject{std::move(file), path};
}

TriangleMesh mesh_of_arrays(const Given<Numbers>& vertices, const Given<Numbers>& facets) {
  if (vertices->shape.size() != 2 || vertices->shape[1] != 3 || facets->shape.size() != 2 || facets->shape[1] != 3) {
    throw InputError("a mesh has vertices of shape (n, 3) and facets of shape (m, 3), which count vertices from 0");
  }
  TriangleMesh mesh;
  for (std::size_t i = 0; i < vertices->shape[0]; ++i) mesh.vertices.emplace_back(vertices->data + 3 * i);
  for (std::size_t i = 0; i < facets->shape[0]; ++i) {
    std::array<std::uint32_t, 3> facet{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double corner = facets->data[3 * i + k];
      if (!(corner >= 0.0 && corner < static_cast<double>(vertices->shape[0]) && corner == std::floor(corner))) {
        throw InputError(
            fmt::format("facet {} (from 0) has the corner {}; there are {} vertices", i, corner, vertices->shape[0]));
      }
      facet[k] = static_cast<std::uint32_t>(corner);
    }
    mesh.facets.push_back(facet);
  }
  return mesh;
}

FloatArray vertices_of(const TriangleMesh& mesh) {
  auto [array, data] = new_array(Shape{mesh.vertices.size(), 3});
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) Eigen::Map<Vector3>(data + 3 * i) = mesh.vertices[i];
  return {std::move(array)};
}

nb::object facets_of(const TriangleMesh& mesh) {
  auto [array, data] = new_array(Shape{mesh.facets.size(), 3});
  for (std::size_t i = 0; i < mesh.facets.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) data[3 * i + k] = mesh.facets[i][k];
  }
  return array.attr("astype")("uint32");
}

void bind_inertia(nb::module_& m) {
  nb::class_<Inertia>(m, "Inertia",
                      "Inertia about the centre of mass. Motion without torques needs the ratios of the moments only; "
                      "torques need kg m2 (`absolute`).")
      .def(
          "__init__",
          [](Inertia* self, const Given<Numbers>& moments, const std::optional<Given<Numbers>>& products,
             const std::string& sign,
             bool absolute) { new (self) Inertia(make_inertia(moments, products, sign, absolute)); },
          "moments"_a, "products"_a = nb::none(), nb::kw_only(), "sign"_a = "tensor elements", "absolute"_a = false,
          "From moments (Ixx, Iyy, Izz) and products (Ixy, Ixz, Iyz) in the body's named axes. `sign` says what the "
          "products are: 'tensor elements' or 'positive integrals' of x y dm, which are minus those. Raises InputError "
          "for what no body has.")
      .def_static(
          "from_tensor",
          [](const Given<Numbers>& tensor, bool absolute) {
            return inertia_from_tensor(tensor->matrix3("the tensor"), absolute);
          },
          "tensor"_a, nb::kw_only(), "absolute"_a = false, "From a symmetric tensor, shape (3, 3).")
      .def_prop_ro(
          "principal_moments", [](const Inertia& self) { return array_of(self.principal_moments); },
          "I1 <= I2 <= I3, shape (3,)")
      .def_prop_ro(
          "named_from_principal", [](const Inertia& self) { return array_of(self.named_from_principal); },
          "The principal axes, as columns, in the named axes: v_named = R v_principal. Shape (3, 3).")
      .def_prop_ro(
          "tensor", [](const Inertia& self) { return array_of(inertia_tensor(self)); },
          "In the named axes, about the centre of mass: shape (3, 3), so that momentum = tensor @ omega.")
      .def_ro("absolute", &Inertia::absolute, "Whether the moments are in kg m2.")
      .def_prop_ro(
          "ellipsoid_axis_ratios", [](const Inertia& self) { return array_of(equivalent_ellipsoid_ratios(self)); },
          "Semi-axes of the homogeneous ellipsoid with these moments, as parts of the longest.")
      .def("__repr__", [](const Inertia& self) {
        const Vector3& I = self.principal_moments;
        return fmt::format("Inertia([{}, {}, {}], absolute={})", I[0], I[1], I[2], self.absolute ? "True" : "False");
      });

  nb::class_<TriangleMesh>(m, "Mesh", "A closed surface of triangles, corners counter-clockwise seen from outside.")
      .def(
          "__init__",
          [](TriangleMesh* self, const Given<Numbers>& vertices, const Given<Numbers>& facets) {
            new (self) TriangleMesh(mesh_of_arrays(vertices, facets));
          },
          "vertices"_a, "facets"_a, "From vertices of shape (n, 3) and facets of shape (m, 3): indices from 0.")
      .def_prop_ro("vertices", &vertices_of, "Shape (n, 3), in the file's unit of length.")
      .def_prop_ro("facets", &facets_of, nb::sig("def facets(self) -> numpy.typing.NDArray[numpy.uint32]"),
                   "Shape (m, 3), indices from 0.")
      .def(
          "mass_properties", [](const TriangleMesh& self) { return mass_properties(self); },
          "Of the solid of density 1 that the mesh bounds. Raises InputError for one that bounds none, naming facets.");
  nb::class_<MassProperties>(m, "MassProperties", "Of a solid of density 1, in the axes and unit of its mesh.")
      .def_ro("volume", &MassProperties::volume)
      .def_prop_ro("centre_of_mass", [](const MassProperties& self) { return array_of(self.centre_of_mass); })
      .def_prop_ro(
          "inertia_about_centre", [](const MassProperties& self) { return array_of(self.inertia_about_centre); },
          "The tensor, shape (3, 3).")
      .def_ro("shells", &MassProperties::shells, "Closed surfaces, cavities included.")
      .def("__repr__", [](const MassProperties& self) { return "<" + describe(self) + ">"; });
  m.def(
      "read_mesh", [](const Given<FileName>& name) { return read_mesh_file(name->path); }, "path"_a,
      "A mesh in OBJ, PLY, STL or DAMIT's shape.txt, by content. Raises InputError, FileError.");
}

void bind_spin_solutions(nb::module_& m) {
  nb::class_<SpinSolution>(m, "SpinSolution", "A tumbling motion that has published periods.")
      .def_ro("long_axis_mode", &SpinSolution::long_axis_mode)
      .def_ro("energy", &SpinSolution::energy, "E/E0 = 2 E I3 / L^2")
      .def_ro("separatrix_distance", &SpinSolution::separatrix_distance, "0 on the separatrix, 1 farthest")
      .def_ro("momentum", &SpinSolution::momentum, "L, unit of the moments times rad/s")
      .def_prop_ro(
          "momentum_at_psi_zero", [](const SpinSolution& self) { return array_of(self.momentum_at_psi_zero); },
          "In principal axes, where psi = 0. Shape (3,).")
      .def(
          "state",
          [](const SpinSolution& self, const Inertia& inertia, double phi_rad, double psi_rad,
             const std::string& convention, bool theta_above_90_deg) {
            const EulerState state =
                state_at(inertia, convention_of(convention), self, phi_rad, psi_rad, theta_above_90_deg);
            return std::tuple(array_of(state.q_momentum_from_principal), array_of(state.momentum_principal),
                              state.theta_rad);
          },
          "inertia"_a, "phi_rad"_a, "psi_rad"_a, "convention"_a = "long axis", "theta_above_90_deg"_a = false,
          "The state at these angles: q from principal axes to axes with z along L (scalar first), L in principal "
          "axes, "
          "and the angle theta between L and the convention's axis.");
  m.def(
      "solve_periods",
      [](const Inertia& inertia, double precession_period_s, double rotation_period_s, const std::string& convention,
         std::optional<bool> long_axis_mode) {
        return solve_periods(inertia,
                             {convention_of(convention), precession_period_s, rotation_period_s, long_axis_mode});
      },
      "inertia"_a, "precession_period_s"_a, "rotation_period_s"_a, "convention"_a = "long axis",
      "long_axis_mode"_a = nb::none(),
      "The motions with these periods P_phi and P_psi as light-curve papers publish them ('long axis' or 'short axis' "
      "convention of Samarasinha & Mueller 2015): one, or one in each mode, short-axis mode first. Raises InputError "
      "where there is none.");
  m.def(
      "energy_at",
      [](const Inertia& inertia, double theta_rad, double psi_rad, const std::string& convention) {
        return energy_at(inertia, convention_of(convention), theta_rad, psi_rad);
      },
      "inertia"_a, "theta_rad"_a, "psi_rad"_a, "convention"_a = "long axis",
      "E/E0 of the state with these angles of the convention.");
  m.def(
      "q_frame_from_momentum",
      [](double longitude_rad, double latitude_rad) {
        return array_of(q_frame_from_momentum(longitude_rad, latitude_rad));
      },
      "longitude_rad"_a, "latitude_rad"_a,
      "v_frame = q v_momentum q*, of axes with z along that direction and x in the plane of it and the frame's z "
      "axis.");

  m.def(
      "q_from_euler",
      [](const std::string& sequence, const Given<Angles>& angles_rad) {
        return array_of(q_frame_from_body(EulerSequence(sequence), angles_rad->vector3("angles_rad")));
      },
      "sequence"_a, "angles_rad"_a,
      "The attitude v_frame = q v_body q* of Euler angles about moving axes, 'ZXZ' or '313' (12 sequences): scalar "
      "first.");
  m.def(
      "euler_angles",
      [](const std::string& sequence, const Given<Attitude>& q) {
        return array_of(euler_angles_rad(EulerSequence(sequence), q->q));
      },
      "sequence"_a, "q"_a, "The three angles of an attitude, rad; the inverse of q_from_euler.");
  m.def(
      "omega_from_euler_rates",
      [](const std::string& sequence, const Given<Angles>& angles_rad, const Given<Rates>& rates_rad_s) {
        return array_of(omega_body_rad_s(EulerSequence(sequence), angles_rad->vector3("angles_rad"),
                                         rates_rad_s->vector3("rates_rad_s")));
      },
      "sequence"_a, "angles_rad"_a, "rates_rad_s"_a,
      "Angular velocity in body axes of angles that change at these rates.");
  m.def(
      "euler_rates",
      [](const std::string& sequence, const Given<Angles>& angles_rad, const Given<Rates>& omega) {
        return array_of(
            euler_rates_rad_s(EulerSequence(sequence), angles_rad->vector3("angles_rad"), omega->vector3("omega")));
      },
      "sequence"_a, "angles_rad"_a, "omega"_a, "The rates of the angles; the inverse of omega_from_euler_rates.");
}

}  // namespace

void bind_body(nb::module_& m) {
  bind_inertia(m);
  bind_spin_solutions(m);

  nb::class_<BodyObject>(m, "Body",
                         "A rigid body: inertia, and its spin state at an epoch. `read` makes one from a file; what is "
                         "not known is None.")
      .def(
          "__init__",
          [](BodyObject* self, const std::string& name, const std::optional<Inertia>& inertia,
             const std::optional<Given<When>>& epoch, const std::string& frame, const std::optional<Given<Attitude>>& q,
             const std::optional<Given<Rates>>& omega, const std::string& source, const std::string& id,
             std::optional<double> period_uncertainty) {
            new (self) BodyObject(make_body(name, inertia, epoch, frame, q, omega, source, id, period_uncertainty));
          },
          "name"_a, nb::kw_only(), "inertia"_a = nb::none(), "epoch"_a = nb::none(), "frame"_a = "ICRF",
          "q"_a = nb::none(), "omega"_a = nb::none(), "source"_a = "", "id"_a = "", "period_uncertainty"_a = nb::none(),
          "Without a file. q: attitude at the epoch, v_frame = q v_named q*, scalar first, or a scipy Rotation (any "
          "length "
          "but 0). omega: rad/s in the named axes. period_uncertainty: one sigma of the periods, as a part of them. "
          "Raises InputError.")
      .def_prop_ro("name", [](const BodyObject& self) { return self.body().name; })
      .def_prop_ro("id", [](const BodyObject& self) { return self.body().id; })
      .def_prop_ro("source", [](const BodyObject& self) { return self.body().source; })
      .def_prop_ro("inertia", [](const BodyObject& self) { return self.body().inertia; })
      .def_prop_ro("epoch",
                   [](const BodyObject& self) {
                     return self.body().state ? std::optional(self.body().state->epoch) : std::nullopt;
                   })
      .def_prop_ro(
          "frame",
          [](const BodyObject& self) {
            return self.body().state ? std::optional(std::string(name(self.body().state->frame))) : std::nullopt;
          },
          "That the state refers to.")
      .def_prop_ro("q", &q_of<BodyObject>, "v_frame = q v_named q* at the epoch, scalar first, shape (4,).")
      .def_prop_ro(
          "omega",
          [](const BodyObject& self) -> std::optional<FloatArray> {
            const auto& state = self.body().state;
            if (!state || !state->omega_named_rad_s) return std::nullopt;
            return array_of(*state->omega_named_rad_s);
          },
          "rad/s at the epoch, named axes, shape (3,).")
      .def(
          "momentum",
          [](const BodyObject& self, const std::string& frame_name) {
            return array_of(momentum_in_frame(self.body(), frame(frame_name)));
          },
          "frame"_a = "ICRF", "Angular momentum in an inertial frame, unit of inertia times rad/s, shape (3,).")
      .def_prop_ro("period_uncertainty", [](const BodyObject& self) { return period_uncertainty(self.body()); })
      .def_prop_ro(
          "missing", [](const BodyObject& self) { return self.body().missing; },
          "What a motion would need and is not known; empty: nothing.")
      .def_prop_ro(
          "notes", [](const BodyObject& self) { return self.body().notes; }, "What was understood.")
      .def_prop_ro(
          "warnings", [](const BodyObject& self) { return self.body().warnings; },
          "What was assumed or looks doubtful.")
      .def_prop_ro(
          "history",
          [](const BodyObject& self) {
            return self.file.history ? std::optional(HistoryObject{self.file, self.path}) : std::nullopt;
          },
          "The attitude history of the same file, or None.")
      .def_prop_ro(
          "path", [](const BodyObject& self) { return self.path; }, "Of the file; empty: there was none.")
      .def(
          "info", [](const BodyObject& self) { return info(self.file, self.path); },
          nb::sig("def info(self) -> dict[str, typing.Any]"),
          "Mode, periods, invariants, axes, warnings: what `polhode info --json` prints, as a dict.")
      .def(
          "motion",
          [](const BodyObject& self, const std::string& frame_name, const std::string& method_name) {
            const Method& chosen = method(method_name);
            return motion_object(
                std::make_shared<BodyInMotion>(free_motion_of(self.body(), inertial_frame(frame_name), chosen)),
                &chosen);
          },
          "frame"_a = "ICRF", "method"_a = "auto",
          "The free motion in an inertial frame. Raises InputError naming what the body lacks.")
      .def("__repr__", [](const BodyObject& self) { return fmt::format("<Body {}>", self.body().name); });

  m.def(
      "read", &read, "path"_a, nb::sig("def read(path: str | os.PathLike[str]) -> typing.Any"),
      "What a file holds, by its content: a Scene, an AttitudeHistory (tables and messages of attitudes), or a Body "
      "(every other format; its `history` has the attitudes that stand beside a complete body). FILE#ROW is a row of a "
      "table of bodies. Raises InputError with file and line, FileError.");
  m.def(
      "input_formats",
      [] {
        std::vector<std::string> names;
        for (const InputFormat& format : input_formats()) names.emplace_back(format.name);
        return names;
      },
      "The formats that `read` recognises.");
}

}  // namespace polhode::python
