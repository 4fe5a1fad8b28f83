#!/usr/bin/env python3
"""Minimax coefficients of kernel.hpp: sine, cosine and exponential on their reduced ranges, by Remez exchange.

Run without arguments; prints C++ arrays, lowest power first, and the largest error of each. Needs mpmath.
"""
import mpmath as mp

mp.mp.prec = 200


def remez(function, weight, low, high, degree):
    """The polynomial of that degree whose weighted error from `function` on [low, high] is least, and that error."""
    n = degree + 2
    points = [(low + high) / 2 - (high - low) / 2 * mp.cos(mp.pi * i / (n - 1)) for i in range(n)]
    for _ in range(12):
        matrix = mp.matrix(n, n)
        right = mp.matrix(n, 1)
        for i, x in enumerate(points):
            for k in range(degree + 1):
                matrix[i, k] = x**k
            matrix[i, degree + 1] = (-1) ** i / weight(x)
            right[i] = function(x)
        solution = mp.lu_solve(matrix, right)
        coefficients = [solution[k] for k in range(degree + 1)]

        def error(x, coefficients=coefficients):
            return (mp.polyval(coefficients[::-1], x) - function(x)) * weight(x)

        grid = [low + (high - low) * mp.mpf(i) / 2000 for i in range(2001)]
        values = [error(x) for x in grid]
        extrema = []
        for i, value in enumerate(values):
            left = values[i - 1] if i > 0 else mp.mpf(0)
            right_value = values[i + 1] if i < len(values) - 1 else mp.mpf(0)
            if abs(value) >= abs(left) * (left * value > 0) and abs(value) >= abs(right_value) * (right_value * value > 0):
                if extrema and values[extrema[-1]] * value > 0:
                    if abs(value) > abs(values[extrema[-1]]):
                        extrema[-1] = i
                else:
                    extrema.append(i)
        while len(extrema) > n:
            extrema.pop(0 if abs(values[extrema[0]]) < abs(values[extrema[-1]]) else -1)
        if len(extrema) == n:
            points = [grid[i] for i in extrema]
    return coefficients, max(abs(v) for v in values)


def show(name, coefficients, error):
    print(f"// largest error 2^{float(mp.log(error, 2)):.1f}")
    print(f"inline constexpr double {name}[] = {{" + ", ".join(float(c).hex() for c in coefficients) + "};")


quarter = mp.pi / 2
limit = mp.mpf("0.252")  # of (quarter turns)^2


def sine_tail(u):  # sin(quarter y) = quarter y + y^3 tail(y^2)
    y = mp.sqrt(u)
    if y < mp.mpf("1e-10"):
        return -(quarter**3) / 6
    return (mp.sin(quarter * y) - quarter * y) / (y * u)


def cosine_tail(u):  # cos(quarter y) = 1 - quarter^2/2 y^2 + y^4 tail(y^2)
    y = mp.sqrt(u)
    if y < mp.mpf("1e-6"):
        return quarter**4 / 24
    return (mp.cos(quarter * y) - 1 + quarter**2 / 2 * u) / u**2


def even_tail(u):  # cosh x = 1 + x^2 tail(x^2)
    return (mp.cosh(mp.sqrt(u)) - 1) / u if u > mp.mpf("1e-20") else mp.mpf(1) / 2


def odd_tail(u):  # sinh x = x + x^3 tail(x^2)
    return (mp.sinh(mp.sqrt(u)) / mp.sqrt(u) - 1) / u if u > mp.mpf("1e-20") else mp.mpf(1) / 6


show("kSineTail", *remez(sine_tail, lambda u: u**mp.mpf("1.5") if u > 0 else mp.mpf("1e-6"), mp.mpf(0), limit, 5))
show("kCosineTail", *remez(cosine_tail, lambda u: u**2 if u > 0 else mp.mpf("1e-6"), mp.mpf(0), limit, 5))
limit = (mp.log(2) / 2 * mp.mpf("1.001")) ** 2
show("kExponentialEven", *remez(even_tail, lambda u: u + mp.mpf("1e-6"), mp.mpf(0), limit, 4))
show("kExponentialOdd", *remez(odd_tail, lambda u: u**mp.mpf("1.5") + mp.mpf("1e-6"), mp.mpf(0), limit, 4))
