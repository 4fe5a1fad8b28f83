#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

/// Dormand and Prince's explicit Runge-Kutta method of order 8 with error estimates of orders 5 and 3 and a continuous
/// extension of order 7 (Hairer, Norsett & Wanner, Solving ODEs I, second edition, section II.10, "DOP853"; the
/// coefficients are those of their program).
namespace polhode::dormand_prince {

inline constexpr std::size_t kStages = 12;       // of a step; the 13th is the first one of the next
inline constexpr std::size_t kStagesOfAll = 16;  // with the three that the continuous extension wants besides

inline constexpr std::array<double, kStagesOfAll> kAbscissae{0.0,
                                                             0.526001519587677318785587544488e-01,
                                                             0.789002279381515978178381316732e-01,
                                                             0.118350341907227396726757197510,
                                                             0.281649658092772603273242802490,
                                                             0.333333333333333333333333333333,
                                                             0.25,
                                                             0.307692307692307692307692307692,
                                                             0.651282051282051282051282051282,
                                                             0.6,
                                                             0.857142857142857142857142857142,
                                                             1.0,
                                                             1.0,
                                                             0.1,
                                                             0.2,
                                                             0.777777777777777777777777777778};

inline constexpr std::array<std::array<double, kStagesOfAll>, kStagesOfAll> kWeights{{
    {},
    {5.26001519587677318785587544488e-2},
    {1.97250569845378994544595329183e-2, 5.91751709536136983633785987549e-2},
    {2.95875854768068491816892993775e-2, 0, 8.87627564304205475450678981324e-2},
    {2.41365134159266685502369798665e-1, 0, -8.84549479328286085344864962717e-1, 9.24834003261792003115737966543e-1},
    {3.7037037037037037037037037037e-2, 0, 0, 1.70828608729473871279604482173e-1, 1.25467687566822425016691814123e-1},
    {3.7109375e-2, 0, 0, 1.70252211019544039314978060272e-1, 6.02165389804559606850219397283e-2, -1.7578125e-2},
    {3.70920001185047927108779319836e-2, 0, 0, 1.70383925712239993810214054705e-1, 1.07262030446373284651809199168e-1,
     -1.53194377486244017527936158236e-2, 8.27378916381402288758473766002e-3},
    {6.24110958716075717114429577812e-1, 0, 0, -3.36089262944694129406857109825, -8.68219346841726006818189891453e-1,
     2.75920996994467083049415600797e1, 2.01540675504778934086186788979e1, -4.34898841810699588477366255144e1},
    {4.77662536438264365890433908527e-1, 0, 0, -2.48811461997166764192642586468, -5.90290826836842996371446475743e-1,
     2.12300514481811942347288949897e1, 1.52792336328824235832596922938e1, -3.32882109689848629194453265587e1,
     -2.03312017085086261358222928593e-2},
    {-9.3714243008598732571704021658e-1, 0, 0, 5.18637242884406370830023853209, 1.09143734899672957818500254654,
     -8.14978701074692612513997267357, -1.85200656599969598641566180701e1, 2.27394870993505042818970056734e1,
     2.49360555267965238987089396762, -3.0467644718982195003823669022},
    {2.27331014751653820792359768449, 0, 0, -1.05344954667372501984066689879e1, -2.00087205822486249909675718444,
     -1.79589318631187989172765950534e1, 2.79488845294199600508499808837e1, -2.85899827713502369474065508674,
     -8.87285693353062954433549289258, 1.23605671757943030647266201528e1, 6.43392746015763530355970484046e-1},
    {5.42937341165687622380535766363e-2, 0, 0, 0, 0, 4.45031289275240888144113950566, 1.89151789931450038304281599044,
     -5.8012039600105847814672114227, 3.1116436695781989440891606237e-1, -1.52160949662516078556178806805e-1,
     2.01365400804030348374776537501e-1, 4.47106157277725905176885569043e-2},
    {5.61675022830479523392909219681e-2, 0, 0, 0, 0, 0, 2.53500210216624811088794765333e-1,
     -2.46239037470802489917441475441e-1, -1.24191423263816360469010140626e-1, 1.5329179827876569731206322685e-1,
     8.20105229563468988491666602057e-3, 7.56789766054569976138603589584e-3, -8.298e-3},
    {3.18346481635021405060768473261e-2, 0, 0, 0, 0, 2.83009096723667755288322961402e-2,
     5.35419883074385676223797384372e-2, -5.49237485713909884646569340306e-2, 0, 0, -1.08347328697249322858509316994e-4,
     3.82571090835658412954920192323e-4, -3.40465008687404560802977114492e-4, 1.41312443674632500278074618366e-1},
    {-4.28896301583791923408573538692e-1, 0, 0, 0, 0, -4.69762141536116384314449447206, 7.68342119606259904184240953878,
     4.06898981839711007970213554331, 3.56727187455281109270669543021e-1, 0, 0, 0, -1.39902416515901462129418009734e-3,
     2.9475147891527723389556272149, -9.15095847217987001081870187138},
}};

inline constexpr std::array<double, 12> kThirdOrder{
    0.244094488188976377952755905512,   0, 0, 0, 0, 0, 0, 0, 0.733846688281611857341361741547, 0, 0,
    0.220588235294117647058823529412e-1};

inline constexpr std::array<double, 12> kFifthOrderError{0.1312004499419488073250102996e-1,
                                                         0,
                                                         0,
                                                         0,
                                                         0,
                                                         -0.1225156446376204440720569753e+1,
                                                         -0.4957589496572501915214079952,
                                                         0.1664377182454986536961530415e+1,
                                                         -0.3503288487499736816886487290,
                                                         0.3341791187130174790297318841,
                                                         0.8192320648511571246570742613e-1,
                                                         -0.2235530786388629525884427845e-1};

inline constexpr std::array<std::array<double, kStagesOfAll>, 4> kDense{{
    {-0.84289382761090128651353491142e+1, 0, 0, 0, 0, 0.56671495351937776962531783590,
     -0.30689499459498916912797304727e+1, 0.23846676565120698287728149680e+1, 0.21170345824450282767155149946e+1,
     -0.87139158377797299206789907490, 0.22404374302607882758541771650e+1, 0.63157877876946881815570249290,
     -0.88990336451333310820698117400e-1, 0.18148505520854727256656404962e+2, -0.91946323924783554000451984436e+1,
     -0.44360363875948939664310572000e+1},
    {0.10427508642579134603413151009e+2, 0, 0, 0, 0, 0.24228349177525818288430175319e+3,
     0.16520045171727028198505394887e+3, -0.37454675472269020279518312152e+3, -0.22113666853125306036270938578e+2,
     0.77334326684722638389603898808e+1, -0.30674084731089398182061213626e+2, -0.93321305264302278729567221706e+1,
     0.15697238121770843886131091075e+2, -0.31139403219565177677282850411e+2, -0.93529243588444783865713862664e+1,
     0.35816841486394083752465898540e+2},
    {0.19985053242002433820987653617e+2, 0, 0, 0, 0, -0.38703730874935176555105901742e+3,
     -0.18917813819516756882830838328e+3, 0.52780815920542364900561016686e+3, -0.11573902539959630126141871134e+2,
     0.68812326946963000169666922661e+1, -0.10006050966910838403183860980e+1, 0.77771377980534432092869265740,
     -0.27782057523535084065932004339e+1, -0.60196695231264120758267380846e+2, 0.84320405506677161018159903784e+2,
     0.11992291136182789328035130030e+2},
    {-0.25693933462703749003312586129e+2, 0, 0, 0, 0, -0.15418974869023643374053993627e+3,
     -0.23152937917604549567536039109e+3, 0.35763911791061412378285349910e+3, 0.93405324183624310003907691704e+2,
     -0.37458323136451633156875139351e+2, 0.10409964950896230045147246184e+3, 0.29840293426660503123344363579e+2,
     -0.43533456590011143754432175058e+2, 0.96324553959188282948394950600e+2, -0.39177261675615439165231486172e+2,
     -0.14972683625798562581422125276e+3},
}};

/// Eight unknowns side by side.
using Unknowns = Eigen::Array<double, 8, 1>;

/// Rows of the tables as types.
template <std::size_t row>
struct StageWeights {
  static constexpr const auto& values = kWeights[row];
};
template <std::size_t row>
struct DenseWeights {
  static constexpr const auto& values = kDense[row];
};
struct ThirdOrder {
  static constexpr const auto& values = kThirdOrder;
};
struct FifthOrderError {
  static constexpr const auto& values = kFifthOrderError;
};

/// The sum of weights[j] k[j], without those that are 0.
template <class Weights>
Unknowns combined(const Unknowns* k) {
  Unknowns sum;
  [&]<std::size_t... j>(std::index_sequence<j...>) {
    for (int lane = 0; lane < 8; ++lane) {
      const auto part = [&]<std::size_t one>(std::integral_constant<std::size_t, one>) {
        return Weights::values[one] * k[one].data()[lane];
      };
      double lanes_sum = 0.0;
      const auto add = [&]<std::size_t one>(std::integral_constant<std::size_t, one> index) {
        if constexpr (Weights::values[one] != 0.0) lanes_sum += part(index);
      };
      (add(std::integral_constant<std::size_t, j>{}), ...);
      sum.data()[lane] = lanes_sum;
    }
  }
  (std::make_index_sequence<Weights::values.size()>{});
  return sum;
}

/// Fills k[first] to k[end - 1] of a step of length h from y at time t; rate(t, y) gives y'.
template <std::size_t first, std::size_t end, class Rate>
void stages(const Rate& rate, double t, const Unknowns& y, double h, Unknowns* k) {
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    ((k[first + i] = rate(t + kAbscissae[first + i] * h, y + h * combined<StageWeights<first + i>>(k))), ...);
  }
  (std::make_index_sequence<end - first>{});
}

/// What a step of length h adds, of the stages 0 to 11.
inline Unknowns increment(double h, const Unknowns* k) { return h * combined<StageWeights<kStages>>(k); }

/// The sums behind the estimates of the error, per unit of time (eq. II.10.16 and 17).
struct Estimates {
  Unknowns fifth, third;

  explicit Estimates(const Unknowns* k)
      : fifth(combined<FifthOrderError>(k)), third(combined<StageWeights<kStages>>(k) - combined<ThirdOrder>(k)) {}

  /// The estimated error of a step of length h, each unknown weighed.
  double error(double h, const Unknowns& weights) const {
    const double fifth_square = (weights * fifth).square().sum(), third_square = (weights * third).square().sum();
    return fifth_square == 0.0 ? 0.0 : std::abs(h) * fifth_square / std::sqrt(fifth_square + 0.01 * third_square);
  }
};

/// The continuous extension of a step.
struct Dense {
  Unknowns start;
  Unknowns f[7];

  /// Of a step that changes nothing.
  explicit Dense(const Unknowns& y) : start(y) {
    for (Unknowns& one : f) one.setZero();
  }
  /// From all 16 stages.
  Dense(const Unknowns& y, double h, const Unknowns* k) : start(y) {
    f[0] = increment(h, k);
    f[1] = h * k[0] - f[0];
    f[2] = 2.0 * f[0] - h * (k[kStages] + k[0]);
    f[3] = h * combined<DenseWeights<0>>(k);
    f[4] = h * combined<DenseWeights<1>>(k);
    f[5] = h * combined<DenseWeights<2>>(k);
    f[6] = h * combined<DenseWeights<3>>(k);
  }
  /// At the part x of the step.
  Unknowns at(double x) const {
    const double rest = 1.0 - x;
    return start + x * (f[0] + rest * (f[1] + x * (f[2] + rest * (f[3] + x * (f[4] + rest * (f[5] + x * f[6]))))));
  }
};

}  // namespace polhode::dormand_prince
