"""Right values that take more than one line. Every function says whose solution it is."""

import numpy as np


def root(f, low, high):
    """Bisection."""
    positive = f(high) > 0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if (f(middle) > 0) == positive:
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)


def elastica_column(load, side, length=1.0):
    """(height, deflection) of the top of a clamped column under load x Euler's load and a side force of side x the load.

    Euler's elastica, th'' = -P sin th - Q cos th, th(0) = 0, th'(1) = 0; Timoshenko and Gere, Theory of Elastic Stability, 2.7.
    """
    p = load * np.pi**2 / 4
    q = side * p
    n = 1000
    h = 1.0 / n

    def slope(y):
        return np.array([y[1], -p * np.sin(y[0]) - q * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])])

    def shoot(k):
        y = np.array([0.0, k, 0.0, 0.0])
        for _ in range(n):
            a = slope(y)
            b = slope(y + h / 2 * a)
            c = slope(y + h / 2 * b)
            y = y + h / 6 * (a + 2 * b + 2 * c + slope(y + h * c))
        return y

    largest = 2 * np.sqrt(p)
    k = root(lambda k: shoot(k)[1], 0.3 * largest, largest)
    return shoot(k)[2:] * length


def neo_hooke_plane_strain(stretch, young, poisson):
    """Nominal stress of a block between smooth plates: the lateral stretch leaves no lateral stress (Simo and Pister 1984)."""
    mu = young / (2 * (1 + poisson))
    lam = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    side = root(lambda s: lam * np.log(stretch * s) + mu * (s * s - 1), 0.1, 10.0)
    return (lam * np.log(stretch * side) + mu * (stretch**2 - 1)) / stretch


def hencky_plastic_bar(stretch, young, yield_stress, hardening):
    """Nominal stress of a bar of von Mises metal in tension, Hencky strain: tau = sy + H (ln l - tau/E), P = tau / l."""
    tau = (yield_stress + hardening * np.log(stretch)) / (1 + hardening / young)
    return tau / stretch


def tunnel_wall(far, inner, cohesion, friction, young, poisson, radius):
    """Inward displacement of the wall of a circular tunnel in Mohr-Coulomb rock without dilatancy (Salencon 1969, Duncan Fama 1993)."""
    s = np.sin(np.radians(friction))
    n = (1 + s) / (1 - s)
    y = 2 * cohesion * np.sqrt(n)
    edge = (2 * far - y) / (n + 1)
    ring = radius * (2 / (n + 1) * (far + y / (n - 1)) / (inner + y / (n - 1))) ** (1 / (n - 1))
    if ring <= radius:
        return (far - inner) * radius * (1 + poisson) / young
    inside = 2 * (1 - poisson) * (far - edge) * (ring / radius) ** 2 - (1 - 2 * poisson) * (far - inner)
    return radius * (1 + poisson) / young * inside


def cylinder_cavity(a0, a, b0, shear_strength, shear_modulus):
    """Pressure in a cylindrical cavity opened from a0 to a in an incompressible tube, outside free (Gibson and Anderson 1961)."""
    c2 = shear_modulus / shear_strength * (a * a - a0 * a0)
    b2 = b0 * b0 + a * a - a0 * a0
    return shear_strength * (1 - c2 / b2 + np.log(c2 / (a * a)))


def disc_in_ring(a, b, young, poisson):
    """Force over displacement of a rigid disc (radius a) in a ring held outside (radius b), plane strain.

    Kolosov and Muskhelishvili: phi = A ln z + B z^2, psi = -kappa A ln z + C/z^2 + D.
    """
    kappa = 3 - 4 * poisson
    g = young / (2 * (1 + poisson))
    return 2 * np.pi * g * (1 + kappa) / (kappa * np.log(b / a) - (b * b - a * a) / (kappa * (a * a + b * b)))


def timoshenko_frequency(length, height, young, poisson, density, n=200):
    """First natural frequency [Hz] of a cantilever with shear (5/6) and rotary inertia: linear elements, one integration point."""
    g = young / (2 * (1 + poisson))
    area, inertia = height, height**3 / 12
    l = length / n
    b = np.array([[0, -1 / l, 0, 1 / l]])
    s = np.array([[-1 / l, -0.5, 1 / l, -0.5]])
    k = young * inertia * l * b.T @ b + 5 / 6 * g * area * l * s.T @ s
    line = np.array([[2, 1], [1, 2]]) * l / 6 * density
    m = np.zeros((4, 4))
    m[np.ix_([0, 2], [0, 2])] = line * area
    m[np.ix_([1, 3], [1, 3])] = line * inertia
    big_k, big_m = np.zeros((2 * n + 2, 2 * n + 2)), np.zeros((2 * n + 2, 2 * n + 2))
    for e in range(n):
        i = slice(2 * e, 2 * e + 4)
        big_k[i, i] += k
        big_m[i, i] += m
    values = np.linalg.eigvals(np.linalg.solve(big_k[2:, 2:], big_m[2:, 2:]))
    return 1 / (2 * np.pi * np.sqrt(values.real.max()))


def falling_bar(gap, young, density, gravity, length=1.0, time=0.8, n=100):
    """Lowest displacement of the lower face of a bar that falls from a gap on an equal bar that stands on a base.

    One-dimensional Hencky bars, central differences, contact by a stiff spring.
    """
    dx = length / n
    m = np.full(n + 1, density * dx)
    m[[0, -1]] /= 2
    low, up = np.arange(n + 1) * dx, length + gap + np.arange(n + 1) * dx
    speed = [np.zeros(n + 1), np.zeros(n + 1)]
    stiff = young / dx
    dt = 0.2 * dx / np.sqrt(young / density)
    lowest = 0.0
    for _ in range(int(time / dt)):
        for x, v, base in ((low, speed[0], True), (up, speed[1], False)):
            l = np.diff(x) / dx
            f = young * np.log(l) / l
            force = -gravity * m
            force[:-1] += f
            force[1:] -= f
            touch = max(0.0, low[-1] - up[0]) * stiff
            if base:
                force[-1] -= touch
            else:
                force[0] += touch
            v += dt * force / m
            if base:
                v[0] = 0.0
        low = low + dt * speed[0]
        up = up + dt * speed[1]
        lowest = min(lowest, up[0] - length - gap)
    return lowest
