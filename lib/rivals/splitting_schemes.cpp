#include "rivals/splitting_schemes.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "polhode/base/error.hpp"

namespace polhode::rivals {
namespace {

constexpr double kBlanesMoan4A[] = {0.0792036964311957, 0.353172906049774, -0.0420650803577195, 0.2193769557534996};
constexpr double kBlanesMoan4B[] = {0.209515106613362, -0.143851773179818, 0.434336666566456};
constexpr double kBlanesMoan6A[] = {0.0502627644003922, 0.413514300428344, 0.0450798897943977,
                                    -0.188054853819569, 0.541960678450780, -0.7255255585086898};
constexpr double kBlanesMoan6B[] = {0.148816447901042, -0.132385865767784, 0.067307604692185, 0.432666402578175,
                                    -0.016404589403618};
constexpr double k84A[] = {0.07534696026989288841861, 0.51791685468825678230077, -0.09326381495814967071938};
constexpr double k84B[] = {0.19022593937367661924523, 0.84652407044352625705508, -1.07350001963440575260062};
constexpr double k104A[] = {0.04706710064597250612947887637243678556564, 0.1847569354170881069247376193702560968574,
                            0.2827060056798362053243616565541452479160, -0.01453004174289681837857815229683813033908};
constexpr double k104B[] = {0.1188819173681970199453503950853885936957, 0.2410504605515015657441667865901651105675,
                            -0.2732866667053238060543113981664559460630, 0.8267085775712504407295884329818044835997};
constexpr double k864A[] = {0.0711334264982231177779387300061549964174, 0.241153427956640098736487795326289649618,
                            0.521411761772814789212136078067994229991, -0.333698616227678005726562603400438876027};
constexpr double k864B[] = {0.183083687472197221961703757166430291072, 0.310782859898574869507522291054262796375,
                            -0.0265646185119588006972121379164987592663, 0.0653961422823734184559721793911134363710};

}  // namespace

std::span<const SplittingScheme> splitting_schemes() {
  static const std::vector<SplittingScheme> all{
      kStrang,
      {"blanes-moan-4", "4", "Blanes & Moan 2002, J. Comput. Appl. Math. 142, 313, S6", 6, kBlanesMoan4A,
       kBlanesMoan4B},
      {"blanes-moan-6", "6", "Blanes & Moan 2002, J. Comput. Appl. Math. 142, 313, S10", 10, kBlanesMoan6A,
       kBlanesMoan6B},
      {"near-8-4", "(8,4)", "McLachlan 1995, BIT 35, 258", 5, k84A, k84B},
      {"near-10-4", "(10,4)", "Blanes et al. 2013, Appl. Numer. Math. 68, 58, ABA", 7, k104A, k104B},
      {"near-8-6-4", "(8,6,4)", "Blanes et al. 2013, Appl. Numer. Math. 68, 58, ABA", 7, k864A, k864B},
      kNear1064,
  };
  return all;
}

const SplittingScheme& splitting_scheme(std::string_view name) {
  std::string allowed;
  for (const SplittingScheme& scheme : splitting_schemes()) {
    if (scheme.name == name) return scheme;
    allowed += fmt::format("{}{}", allowed.empty() ? "" : ", ", scheme.name);
  }
  throw InputError(fmt::format("unknown splitting scheme '{:.40}', allowed are {}", name, allowed));
}

}  // namespace polhode::rivals
