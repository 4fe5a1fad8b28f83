// Compiles and links where cvode_adams.cpp does: SUNDIALS 6 or 7, with all that its headers and libraries need.
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

int main() {
  double y = 0.0;
#if SUNDIALS_VERSION_MAJOR >= 7
  const SUNComm no_communicator = SUN_COMM_NULL;
#else
  void* const no_communicator = nullptr;
#endif
  SUNContext context = nullptr;
  const bool made = SUNContext_Create(no_communicator, &context) == 0;
  return made && CVodeCreate(CV_ADAMS, context) && SUNNonlinSol_FixedPoint(N_VMake_Serial(1, &y, context), 0, context)
             ? 0
             : 1;
}
