#pragma once

// Some code is compiled once per instruction set. Everything inline that such a file uses stands in an inline namespace
// named after the target, so that the linker can never give baseline code a function compiled for a newer machine.
#ifndef POLHODE_TARGET
#define POLHODE_TARGET baseline
#endif
