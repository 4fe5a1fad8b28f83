"""The free rigid body to any number of digits, by Leroy's formulas (Leroy 2020, "An alternative
quaternionic solution") in mpmath: Jacobi functions and Legendre's Pi, nothing shared with the library's theta series.

Cases (i) and (ii) only: no symmetric top, sphere, separatrix to the last digit or constant momentum.
"""
import mpmath as mp


def _multiply(a, b):
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


def _conjugate(a):
    return (a[0], -a[1], -a[2], -a[3])


class FreeMotionReference:
    """moments ascending, q scalar first (body to inertial), m in the principal axes; all taken as exact."""

    def __init__(self, moments, q, m, digits):
        mp.mp.dps = digits
        i1, i2, i3 = (mp.mpf(x) for x in moments)
        m = [mp.mpf(x) for x in m]
        q = [mp.mpf(x) for x in q]
        norm = mp.sqrt(sum(x * x for x in q))
        q = [x / norm for x in q]
        g = mp.sqrt(sum(x * x for x in m))
        d1 = m[1] ** 2 * (i2 - i1) / i2 + m[2] ** 2 * (i3 - i1) / i3
        d3 = m[0] ** 2 * (i1 - i3) / i1 + m[1] ** 2 * (i2 - i3) / i2
        d2 = m[0] ** 2 * (i1 - i2) / i1 + m[2] ** 2 * (i3 - i2) / i3
        assert d2 != 0 and i1 < i2 < i3
        self.case = "i" if d2 < 0 else "ii"
        # S turns the preferred component (1 or 3) positive by a rotation by pi about the second axis.
        kept = m[0] if d2 < 0 else m[2]
        self.s = (mp.mpf(1), 0, 0, 0) if kept > 0 else (mp.mpf(0), 0, mp.mpf(1), 0)
        self.sign = 1 if kept > 0 else -1
        m = [m[0] * self.sign, m[1], m[2] * self.sign]
        self.i1, self.i2, self.i3, self.g = i1, i2, i3, g
        self.b13 = mp.sqrt(i1 * d3 / (i1 - i3))
        self.b31 = mp.sqrt(i3 * d1 / (i3 - i1))
        if d2 < 0:
            self.b2 = mp.sqrt(i2 * d1 / (i2 - i1))
            self.mc = d2 * (i3 - i1) / (d3 * (i2 - i1))
            self.lam = -mp.sqrt(d3 * (i1 - i2) / (i1 * i2 * i3))
            nu = mp.atan2(m[1] / self.b2, m[2] / self.b31)
            self.n = i1 * (i3 - i2) / (i3 * (i1 - i2))
            self.pi_factor = g * (i1 - i3) / (self.lam * i1 * i3)
            self.arc = (-1, mp.sqrt(i2 * (i3 - i1) / (i3 * (i2 - i1))))
            self.rate = g / i1
        else:
            self.b2 = mp.sqrt(i2 * d3 / (i2 - i3))
            self.mc = d2 * (i3 - i1) / (d1 * (i3 - i2))
            self.lam = -mp.sqrt(d1 * (i3 - i2) / (i1 * i2 * i3))
            nu = mp.atan2(m[1] / self.b2, m[0] / self.b13)
            self.n = i3 * (i2 - i1) / (i1 * (i2 - i3))
            self.pi_factor = g * (i3 - i1) / (self.lam * i1 * i3)
            self.arc = (1, mp.sqrt(i2 * (i3 - i1) / (i1 * (i3 - i2))))
            self.rate = g / i3
        self.m = 1 - self.mc
        self.k = mp.ellipk(self.m)
        self.pi_complete = mp.ellippi(self.n, self.m)
        self.nu = self._f(nu)
        at_0 = self._chain(mp.mpf(0))[0]
        self.r = _multiply(q, _conjugate(at_0))

    def _f(self, phi):
        whole = mp.nint(phi / mp.pi)
        return 2 * whole * self.k + mp.ellipf(phi - whole * mp.pi, self.m)

    def _chain(self, t):
        u = self.lam * t - self.nu
        whole = mp.nint(u / (2 * self.k))
        reduced = u - 2 * whole * self.k
        sn = mp.ellipfun("sn", reduced, m=self.m)
        cn = mp.ellipfun("cn", reduced, m=self.m)
        dn = mp.ellipfun("dn", reduced, m=self.m)
        phi = mp.atan2(sn, cn)
        side, factor = self.arc
        psi = (
            self.rate * t
            + self.pi_factor * (2 * whole * self.pi_complete + mp.ellippi(self.n, phi, self.m))
            + side * (whole * mp.pi + mp.atan2(factor * sn, cn))
        )
        flip = -1 if int(whole) % 2 else 1
        sn, cn = sn * flip, cn * flip
        g = self.g
        half = psi / 2
        if self.case == "i":
            m = (self.b13 * dn, -self.b2 * sn, self.b31 * cn)
            root = mp.sqrt(2 * g * (g + m[0]))
            p = (mp.sqrt((1 + m[0] / g) / 2), 0, m[2] / root, -m[1] / root)
            y = (mp.cos(half), mp.sin(half), 0, 0)
        else:
            m = (self.b13 * cn, -self.b2 * sn, self.b31 * dn)
            root = mp.sqrt(2 * g * (g + m[2]))
            p = (mp.sqrt((1 + m[2] / g) / 2), m[1] / root, -m[0] / root, 0)
            y = (mp.cos(half), 0, 0, mp.sin(half))
        return _multiply(_multiply(y, p), self.s), (m[0] * self.sign, m[1], m[2] * self.sign)

    def at(self, t):
        """(q, m) at t seconds, exact to roughly the digits asked for less those of the number of turns."""
        chain, m = self._chain(mp.mpf(t))
        return _multiply(self.r, chain), m
