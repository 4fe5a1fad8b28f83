#pragma once

// The arithmetic of brightness over many instants, compiled once per instruction set (target_*.cpp); shape.cpp chooses
// at run time. Separate arrays throughout: [0], [1], [2] are x, y, z.

#include <cstddef>

namespace polhode::brightness {

/// Unit vectors towards the observer and towards the Sun.
struct Directions {
  const double* observer[3];
  const double* sun[3];
};

/// Of one instant each: the brightness by the scattering law, and the area that is lit and seen, projected towards the
/// observer.
struct Results {
  double* brightness;
  double* area;
};

/// A surface of triangles. Vectors normal to the facets, as long as their areas; facets are padded with zeros to a
/// multiple of 8.
struct FacetArrays {
  const double* normal[3];
  const double* inverse_area;  ///< 0 where the facet is padding
  std::size_t count;
};

/// Weights of Lommel-Seeliger's mu mu0 / (mu + mu0) and of Lambert's mu mu0; both 0: the brightness is the area.
struct LawWeights {
  double lommel_seeliger, lambert;
};

struct Kernels {
  const char* name;
  int lanes;
  /// out = map R(q)^T v for each instant's attitude q (scalar first) and both of its directions; `map` in rows.
  void (*turn)(std::size_t count, const double* const q[4], const Directions& in, const double (&map)[9],
               double* const observer[3], double* const sun[3]);
  /// Of an ellipsoid, directions stretched by the inverse semi-axes; `volume` is the product of these.
  void (*ellipsoid_area)(std::size_t count, const Directions& stretched, double volume, double* area);
  /// Its brightness by Lommel and Seeliger's law, in closed form.
  void (*ellipsoid_lommel_seeliger)(std::size_t count, const Directions& stretched, double volume, double* brightness);
  /// Of the facets that are lit and seen, as if none hid another.
  void (*facets)(std::size_t count, const Directions& in, const FacetArrays& facets, const LawWeights& law,
                 const Results& out);
};

/// Those that this machine can run, the quickest last.
std::size_t kernels(const Kernels* out[3]);
/// The quickest, or the one that the environment variable POLHODE_TARGET names.
const Kernels& best_kernels();

}  // namespace polhode::brightness
