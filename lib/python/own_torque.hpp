#pragma once

#include <atomic>
#include <cstddef>
#include <optional>

#include "polhode/torque/own_torque.hpp"
#include "python/python.hpp"

namespace polhode::python {

/// A torque of one's own, of which Python says how large it may be and whether it has kinks.
class DescribedTorque : public TorqueFunction {
 public:
  /// Throws InputError for a largest torque that is none.
  DescribedTorque(bool kinks, std::optional<double> largest);
  bool has_kinks() const override { return kinks_; }
  double largest(double t_s, double momentum) const override {
    return largest_ ? *largest_ : TorqueFunction::largest(t_s, momentum);
  }

 private:
  bool kinks_;
  std::optional<double> largest_;
};

/// By a callable. It is called with the interpreter's lock, which nobody who asks a motion needs to have; exceptions go
/// to whoever asked.
class PythonTorque final : public DescribedTorque {
 public:
  PythonTorque(nb::object function, bool with_orbit, bool kinks, std::optional<double> largest)
      : DescribedTorque(kinks, largest), function_(std::move(function)), with_orbit_(with_orbit) {}
  ~PythonTorque() override;
  PythonTorque(const PythonTorque&) = delete;
  PythonTorque& operator=(const PythonTorque&) = delete;

  Vector3 torque(const TorqueQuestion& at) const override;

 private:
  nb::object function_;
  bool with_orbit_;
};

/// By machine code, without the lock; signals (Ctrl-C) are looked for now and then.
class CompiledTorque final : public DescribedTorque {
 public:
  /// Throws InputError for what is no function pointer, or says that its signature is another one.
  CompiledTorque(nb::object function, bool kinks, std::optional<double> largest);
  ~CompiledTorque() override;
  CompiledTorque(const CompiledTorque&) = delete;
  CompiledTorque& operator=(const CompiledTorque&) = delete;

  Vector3 torque(const TorqueQuestion& at) const override;

 private:
  using Function = void (*)(double, const double*, const double*, const double*, double*);
  nb::object kept_;  // it owns the code
  Function function_;
  mutable std::atomic<std::size_t> calls_{0};
};

}  // namespace polhode::python
