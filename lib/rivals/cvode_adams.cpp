#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <memory>

#include "rivals/fixed_step.hpp"
#include "rivals/general_purpose.hpp"
#include "rivals/right_hand_side.hpp"

namespace polhode::rivals {

namespace {

// Errors are seen from what a call returns; no message goes to the standard error stream.
#if SUNDIALS_VERSION_MAJOR >= 7
const SUNComm no_communicator = SUN_COMM_NULL;
int silence(SUNContext context, void*) { return SUNContext_ClearErrHandlers(context); }
#else
void* const no_communicator = nullptr;
int silence(SUNContext, void* cvode) {
  return CVodeSetErrHandlerFn(
      cvode, [](int, const char*, const char*, char*, void*) {}, nullptr);
}
#endif

template <class RightHandSide>
int derivative(sunrealtype t, N_Vector y, N_Vector dydt, void* rate) {
  std::array<double, 7> from, to;
  std::copy_n(NV_DATA_S(y), 7, from.begin());
  (*static_cast<const RightHandSide*>(rate))(from, to, t);
  std::copy_n(to.begin(), 7, NV_DATA_S(dydt));
  return 0;
}

template <class T, class Free>
std::unique_ptr<T, Free> owned(T* p, Free free) {
  return {p, free};
}

template <class RightHandSide>
std::int64_t run(RightHandSide f, const Problem& problem, std::span<const double> times, ScaledState<double>* out) {
  SUNContext raw_context = nullptr;
  if (SUNContext_Create(no_communicator, &raw_context) != 0) {
    no_answer(out, 0, times.size());
    return 0;
  }
  const auto context = owned(raw_context, [](SUNContext c) { SUNContext_Free(&c); });
  std::array<double, 7> y = pack(problem.start);
  const auto vector = owned(N_VMake_Serial(7, y.data(), context.get()), N_VDestroy);
  const auto memory = owned(CVodeCreate(CV_ADAMS, context.get()), [](void* m) { CVodeFree(&m); });
  const auto iteration = owned(SUNNonlinSol_FixedPoint(vector.get(), 0, context.get()), SUNNonlinSolFree);
  void* const cvode = memory.get();
  std::size_t done = 0;
  long evaluations = 0;
  if (CVodeInit(cvode, derivative<RightHandSide>, 0.0, vector.get()) == CV_SUCCESS &&
      CVodeSStolerances(cvode, problem.tolerance, problem.tolerance) == CV_SUCCESS &&
      CVodeSetUserData(cvode, &f) == CV_SUCCESS && CVodeSetNonlinearSolver(cvode, iteration.get()) == CV_SUCCESS &&
      silence(context.get(), cvode) == 0 &&
      CVodeSetMaxNumSteps(cvode, static_cast<long>(problem.max_evaluations)) == CV_SUCCESS) {
    for (; done < times.size(); ++done) {
      double t = 0.0;
      if (times[done] != 0.0 && CVode(cvode, times[done], vector.get(), &t, CV_NORMAL) < 0) break;
      CVodeGetNumRhsEvals(cvode, &evaluations);
      if (evaluations > problem.max_evaluations) break;
      out[done] = unpack(y);
      if (!is_finite(out[done])) break;
    }
  }
  no_answer(out, done, times.size());
  CVodeGetNumRhsEvals(cvode, &evaluations);
  return evaluations;
}

}  // namespace

std::int64_t run_cvode_adams(const Problem& problem, std::span<const double> times, ScaledState<double>* out) {
  return with_right_hand_side(problem, [&](const auto& rate) { return run(rate, problem, times, out); });
}

}  // namespace polhode::rivals
