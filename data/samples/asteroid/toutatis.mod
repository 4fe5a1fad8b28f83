{MODEL FILE, the spin state alone; numbers of Takahashi, Busch & Scheeres 2013}
{SPIN STATE}
 1992 11  9 17 49 47 {yyyy mo dd hh mm ss of t0}
 c   145.498000000000 {angle 0 (deg) lambda=55.498000}
 c    65.865000000000 {angle 1 (deg) beta=24.135000}
 c   241.524000000000 {angle 2 (deg)}
 f    14.510000000000 {spin 0 (deg/day)}
 f    33.529000000000 {spin 1 (deg/day)}
 f   -98.709000000000 {spin 2 (deg/day)}
 c     3.083600000000 {moment of inertia 0}
 c     3.235000000000 {moment of inertia 1}
 c     1.000000000000 {moment of inertia 2}
 c     0.000000000000 {spin 0 dot (deg/day/day)}
 c     0.000000000000 {spin 1 dot (deg/day/day)}
 c     0.000000000000 {spin 2 dot (deg/day/day)}
 c     0.000000000000 {Libration Amplitude (degrees)}
 c     0.000000000000 {Libration Frequency (degrees/day)}
 c     0.000000000000 {Libration Phase (degrees)}
                  0 {number of spin impulses}
