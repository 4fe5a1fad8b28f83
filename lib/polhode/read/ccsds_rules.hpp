#pragma once

#include <array>

#include "polhode/read/ccsds_fields.hpp"

/// The standard's tables of keywords: which may and which must stand in each block of an attitude message, in which
/// version. The first missing one of a table is the one that a message names.
namespace polhode::ccsds_rules {

using enum CcsdsValue;
using enum CcsdsUse;

inline constexpr std::string_view directions = "A2B B2A";
inline constexpr std::string_view moment = "kg*m**2";

inline constexpr auto header = std::to_array<CcsdsRule>(
    {{"CLASSIFICATION MESSAGE_ID"}, {"CREATION_DATE", required, epoch}, {"ORIGINATOR", required}});

// --- APM

inline constexpr auto apm_metadata =
    std::to_array<CcsdsRule>({{"OBJECT_NAME OBJECT_ID", required}, {"CENTER_NAME"}, {"TIME_SYSTEM", required}});

inline constexpr auto apm_data = std::to_array<CcsdsRule>({{"EPOCH", required, epoch}});

inline constexpr auto quat = std::to_array<CcsdsRule>({{"EPOCH", required_v1, epoch},
                                                       {"Q_FRAME_A Q_FRAME_B", required_v1},
                                                       {"Q_DIR", required_v1, text, {}, directions},
                                                       {"REF_FRAME_A REF_FRAME_B", required_v2},
                                                       {"Q1 Q2 Q3 QC", required, number},
                                                       {"Q1_DOT Q2_DOT Q3_DOT QC_DOT", optional, number, "1/s"}});

// The angles and rates of version 1 are named by axis and may come twice; they are renamed ANGLE_n, ANGLE_n_DOT first.
inline constexpr auto euler =
    std::to_array<CcsdsRule>({{"EULER_FRAME_A EULER_FRAME_B", required_v1},
                              {"EULER_DIR", required_v1, text, {}, directions},
                              {"REF_FRAME_A REF_FRAME_B", required_v2},
                              {"EULER_ROT_SEQ", required, sequence},
                              {"ANGLE_1 ANGLE_2 ANGLE_3", required_v2_optional_v1, angle, "deg"},
                              {"ANGLE_1_DOT ANGLE_2_DOT ANGLE_3_DOT", optional, number, "deg/s"},
                              {"RATE_FRAME", optional_v1, text, {}, "EULER_FRAME_A EULER_FRAME_B"},
                              {"RATE_FRAME", optional_v2}});  // of version 1; read with a warning

inline constexpr auto angvel = std::to_array<CcsdsRule>(
    {{"REF_FRAME_A REF_FRAME_B ANGVEL_FRAME", required}, {"ANGVEL_X ANGVEL_Y ANGVEL_Z", required, number, "deg/s"}});

inline constexpr auto spin = std::to_array<CcsdsRule>({{"SPIN_FRAME_A SPIN_FRAME_B", required_v1},
                                                       {"SPIN_DIR", required_v1, text, {}, directions},
                                                       {"REF_FRAME_A REF_FRAME_B", required_v2},
                                                       {"SPIN_ALPHA SPIN_DELTA SPIN_ANGLE", required, angle, "deg"},
                                                       {"SPIN_ANGLE_VEL", required, number, "deg/s"},
                                                       {"NUTATION NUTATION_PHASE", optional, angle, "deg"},
                                                       {"NUTATION_PER", optional, not_zero, "s"},
                                                       {"MOMENTUM_ALPHA MOMENTUM_DELTA", optional_v2, angle, "deg"},
                                                       {"NUTATION_VEL", optional_v2, number, "deg/s"}});

inline constexpr auto inertia = std::to_array<CcsdsRule>({{"INERTIA_REF_FRAME", required_v2_optional_v1},
                                                          {"IXX IYY IZZ", required_v2, positive, moment},
                                                          {"IXY IXZ IYZ", required_v2, number, moment},
                                                          {"I11 I22 I33", required_v1, positive, moment},
                                                          {"I12 I13 I23", required_v1, number, moment}});

inline constexpr auto apm_man = std::to_array<CcsdsRule>({{"MAN_EPOCH_START", required, epoch},
                                                          {"MAN_DURATION", required, not_negative, "s"},
                                                          {"MAN_REF_FRAME", required},
                                                          {"MAN_TOR_X MAN_TOR_Y MAN_TOR_Z", required_v2, number, "N*m"},
                                                          {"MAN_TOR_1 MAN_TOR_2 MAN_TOR_3", required_v1, number, "N*m"},
                                                          {"MAN_DELTA_MASS", optional_v2, not_positive, "kg"}});

// --- AEM

inline constexpr std::string_view attitude_types =
    "QUATERNION QUATERNION/DERIVATIVE QUATERNION/ANGVEL QUATERNION/RATE EULER_ANGLE EULER_ANGLE/DERIVATIVE "
    "EULER_ANGLE/ANGVEL EULER_ANGLE/RATE SPIN SPIN/NUTATION SPIN/NUTATION_MOM";

// RATE_FRAME belongs to version 1, ANGVEL_FRAME to version 2; each is read in the other, with a warning.
inline constexpr auto aem_metadata =
    std::to_array<CcsdsRule>({{"OBJECT_NAME OBJECT_ID", required},
                              {"REF_FRAME_A REF_FRAME_B", required},
                              {"ATTITUDE_DIR", required_v1, text, {}, directions},
                              {"TIME_SYSTEM", required},
                              {"START_TIME STOP_TIME", required, epoch},
                              {"USEABLE_START_TIME USEABLE_STOP_TIME", optional, epoch},
                              {"ATTITUDE_TYPE", required, text, {}, attitude_types},
                              {"QUATERNION_TYPE", optional_v1, text, {}, "FIRST LAST"},
                              {"EULER_ROT_SEQ", optional, sequence},
                              {"CENTER_NAME ANGVEL_FRAME RATE_FRAME INTERPOLATION_METHOD"},
                              {"INTERPOLATION_DEGREE", optional, integer}});

// --- ACM, of version 2 alone

inline constexpr auto acm_metadata = std::to_array<CcsdsRule>(
    {{"CLASSIFICATION INTERNATIONAL_DESIGNATOR CATALOG_NAME OBJECT_DESIGNATOR ORIGINATOR_POC ORIGINATOR_POSITION "
      "ORIGINATOR_PHONE ORIGINATOR_EMAIL ORIGINATOR_ADDRESS ODM_MSG_LINK CENTER_NAME ACM_DATA_ELEMENTS"},
     {"OBJECT_NAME TIME_SYSTEM", required},
     {"EPOCH_TZERO", required, epoch},
     {"START_TIME STOP_TIME", optional, CcsdsValue::time},
     {"NEXT_LEAP_EPOCH", optional, epoch},
     {"TAIMUTC_AT_TZERO NEXT_LEAP_TAIMUTC", optional, number, "s"}});

inline constexpr std::string_view states = "QUATERNION EULER_ANGLES DCM";
inline constexpr std::string_view rates = "ANGVEL Q_DOT EULER_RATE GYRO_BIAS NONE";

inline constexpr auto att = std::to_array<CcsdsRule>({{"ATT_ID ATT_PREV_ID ATT_BASIS ATT_BASIS_ID"},
                                                      {"REF_FRAME_A REF_FRAME_B", required},
                                                      {"NUMBER_STATES", required, integer},
                                                      {"ATT_TYPE", required, text, {}, states},
                                                      {"EULER_ROT_SEQ", optional, sequence},
                                                      {"RATE_TYPE", optional, text, {}, rates}});

inline constexpr auto phys = std::to_array<CcsdsRule>({{"DRAG_COEFF", optional, not_negative},
                                                       {"WET_MASS DRY_MASS", optional, positive, "kg"},
                                                       {"CP_REF_FRAME INERTIA_REF_FRAME"},
                                                       {"CP", optional, vector, "m"},
                                                       {"IXX IYY IZZ", optional, positive, moment},
                                                       {"IXY IXZ IYZ", optional, number, moment}});

inline constexpr std::string_view covariances =
    "ANGLE ANGLE_GYROBIAS ANGLE_ANGVEL QUATERNION QUATERNION_GYROBIAS QUATERNION_ANGVEL";
inline constexpr std::string_view covariances_or_none =
    "ANGLE ANGLE_GYROBIAS ANGLE_ANGVEL QUATERNION QUATERNION_GYROBIAS QUATERNION_ANGVEL NONE";

inline constexpr auto cov = std::to_array<CcsdsRule>(
    {{"COV_ID COV_PREV_ID COV_BASIS COV_BASIS_ID COV_REF_FRAME"}, {"COV_TYPE", required, text, {}, covariances}});

inline constexpr auto acm_man = std::to_array<CcsdsRule>({{"MAN_ID MAN_PREV_ID ACTUATOR_USED TARGET_MOM_FRAME"},
                                                          {"MAN_PURPOSE", required},
                                                          {"MAN_BEGIN_TIME", required, CcsdsValue::time, "s"},
                                                          {"MAN_END_TIME", optional, CcsdsValue::time, "s"},
                                                          {"MAN_DURATION", optional, not_negative, "s"},
                                                          {"TARGET_MOMENTUM", optional, vector, "N*m*s"},
                                                          {"TARGET_ATTITUDE", optional, quaternion},
                                                          {"TARGET_SPINRATE", optional, number, "deg/s"}});

inline constexpr auto ad =
    std::to_array<CcsdsRule>({{"AD_ID AD_PREV_ID ATTITUDE_SOURCE"},
                              {"AD_METHOD", optional, text, {}, "EKF TRIAD QUEST BATCH Q_METHOD FILTER_SMOOTHER"},
                              {"NUMBER_STATES", optional, integer},
                              {"ATTITUDE_STATES", required, text, {}, states},
                              {"EULER_ROT_SEQ", optional, sequence},
                              {"COV_TYPE", optional, text, {}, covariances_or_none},
                              {"REF_FRAME_A REF_FRAME_B", required},
                              {"RATE_STATES", optional, text, {}, rates},
                              {"SIGMA_U RATE_PROCESS_NOISE_STDDEV", optional, not_negative, "deg/s**1.5"},
                              {"SIGMA_V", optional, not_negative, "deg/s**0.5"}});

inline constexpr auto sensor = std::to_array<CcsdsRule>({{"SENSOR_NUMBER", required, integer},
                                                         {"SENSOR_USED"},
                                                         {"NUMBER_SENSOR_NOISE_COVARIANCE", optional, integer},
                                                         {"SENSOR_NOISE_STDDEV", optional, numbers, "deg"},
                                                         {"SENSOR_FREQUENCY", optional, positive, "Hz"}});

inline constexpr auto user = std::to_array<CcsdsRule>({{"USER_DEFINED_"}});

}  // namespace polhode::ccsds_rules
