// Boost.odeint's dopri5 with dense output, as a C++ user would tune it: one flat state, force loops that vectorise,
// scratch allocated once, and the dense state evaluated only where the middle site's speed may exceed the best so far.
#include <algorithm>
#include <boost/numeric/odeint.hpp>
#include <boost/version.hpp>
#include <cmath>
#include <limits>
#include <vector>

using State = std::vector<double>;  // u_0 .. u_N, v_0 .. v_N; index 0 is the impactor

// The springs of kernel.laws: tension at strain e, from the law's numbers.
struct Linear {
    explicit Linear(const double *) {}
    double operator()(double e) const { return e; }
};
struct Bistable {
    double c2, c3;
    explicit Bistable(const double *law) : c2(law[0]), c3(law[1]) {}
    double operator()(double e) const {
        const double m = e < 0.0 ? e : 0.0;
        return e + m * m * (c2 + c3 * m);
    }
};
struct Polynomial {
    double c2, c3;
    explicit Polynomial(const double *law) : c2(law[0]), c3(law[1]) {}
    double operator()(double e) const { return e + e * e * (c2 + c3 * e); }
};
template <int pieces>
struct PiecewiseLinear {
    double strain[pieces], more[pieces];  // where the slope changes, and by how much
    explicit PiecewiseLinear(const double *law) {
        for (int k = 0; k < pieces; ++k)
            strain[k] = law[k], more[k] = law[pieces + k] - (k > 0 ? law[pieces + k - 1] : 1.0);
    }
    double operator()(double e) const {
        double total = e;
        for (int k = 0; k < pieces; ++k) total += more[k] * std::min(e + strain[k], 0.0);
        return total;
    }
};
template <bool hertz>
struct Power {
    double n, d;
    explicit Power(const double *law) : n(law[0]), d(law[1]) {}
    double operator()(double e) const {
        const double y = std::max(1.0 - e / d, 0.0);
        return d / n * (1.0 - (hertz ? y * std::sqrt(y) : std::pow(y, n)));
    }
};
struct Toda {
    double b;
    explicit Toda(const double *law) : b(law[0]) {}
    double operator()(double e) const { return (1.0 - std::exp(-b * e)) / b; }
};

template <class Spring>
struct Chain {
    int N;
    double zeta;
    Spring tension;
    double K, mass;
    mutable State g;  // tension of link i between sites i and i+1; g[0] is minus the contact force

    double push(double overlap) const { return overlap > 0.0 ? K * overlap * std::sqrt(overlap) : 0.0; }
    double link(const double *u, const double *v, int i) const {
        if (i == 0) return -push(u[0] - u[1]);
        const double right_u = i < N ? u[i + 1] : 0.0, right_v = i < N ? v[i + 1] : 0.0;
        return tension(right_u - u[i]) + 2.0 * zeta * (right_v - v[i]);
    }
    double acceleration(const State &y, int i) const {
        return link(y.data(), y.data() + N + 1, i) - link(y.data(), y.data() + N + 1, i - 1);
    }
    void operator()(const State &y, State &dy, double) const {
        const int n = N + 1;
        const double *__restrict u = y.data(), *__restrict v = y.data() + n;
        double *__restrict du = dy.data(), *__restrict a = dy.data() + n, *__restrict t = g.data();
        const double eta = 2.0 * zeta;
        t[0] = link(u, v, 0);
        if (eta > 0.0)
            for (int i = 1; i < N; ++i) t[i] = tension(u[i + 1] - u[i]) + eta * (v[i + 1] - v[i]);
        else
            for (int i = 1; i < N; ++i) t[i] = tension(u[i + 1] - u[i]);
        t[N] = link(u, v, N);
        for (int i = 0; i < n; ++i) du[i] = v[i];
        for (int i = 1; i < n; ++i) a[i] = t[i] - t[i - 1];
        a[0] = t[0] / mass;
    }
};

// Where in (0, 1) of a step |v| may exceed `best`: the larger crest of the cubic through both ends, or -1.
static double crest(double v0, double a0, double v1, double a1, double h, double best) {
    const double b = v0 + h * a0 / 3.0, c = v1 - h * a1 / 3.0;
    if (std::max({std::fabs(v0), std::fabs(b), std::fabs(c), std::fabs(v1)}) < 0.99 * best) return -1.0;
    const double p = b - v0, q = c - b, r = v1 - c, root = q * q - p * r;
    if (!(root >= 0.0)) return -1.0;
    double where = -1.0, largest = -1.0;
    for (double sign : {-1.0, 1.0}) {
        const double below = p - q + sign * std::sqrt(root), x = below != 0.0 ? p / below : -1.0, w = 1.0 - x;
        if (!(x > 0.0 && x < 1.0)) continue;
        const double value = std::fabs(w * w * w * v0 + 3 * x * w * w * b + 3 * x * x * w * c + x * x * x * v1);
        if (value > largest) where = x, largest = value;
    }
    return where;
}

// A program built with -ffast-math runs without subnormal numbers; here that holds until the peer returns.
struct NoSubnormals {
#ifdef __SSE2__
    const unsigned before = __builtin_ia32_stmxcsr();
    NoSubnormals() { __builtin_ia32_ldmxcsr(before | 0x8040); }
    ~NoSubnormals() { __builtin_ia32_ldmxcsr(before); }
#endif
};

template <class Spring>
static double peak(int N, const double *law, const double *p, double t_end, double rtol, double atol) {
    namespace odeint = boost::numeric::odeint;
    const NoSubnormals guard;
    const Chain<Spring> chain{N, p[0], Spring(law), p[1], p[2], State(N + 1)};
    const int mid = (N + 1) / 2, at = N + 1 + mid;
    State y(2 * (N + 1), 0.0), dense(2 * (N + 1));
    y[N + 1] = p[3];
    auto stepper = odeint::make_dense_output(atol, rtol, odeint::runge_kutta_dopri5<State>());
    stepper.initialize(y, 0.0, 1e-3);
    double best = 0.0, v = 0.0, a = 0.0;
    try {
        while (stepper.current_time() < t_end) {
            const auto [t, t_next] = stepper.do_step(std::cref(chain));
            const State &next = stepper.current_state();
            const double v_next = next[at], a_next = chain.acceleration(next, mid), h = t_next - t;
            const double x = crest(v, a, v_next, a_next, h, best);
            if (x > 0.0 && t + x * h <= t_end) {
                stepper.calc_state(t + x * h, dense);
                best = std::max(best, std::fabs(dense[at]));
            }
            if (t_next > t_end) stepper.calc_state(t_end, dense);
            best = std::max(best, std::fabs(t_next > t_end ? dense[at] : v_next));
            v = v_next, a = a_next;
        }
    } catch (const std::exception &) {
        return std::numeric_limits<double>::quiet_NaN();
    }
    return best;
}

// law: its name's place in tests/peers/odeint.py, and its numbers; p = {zeta, K, impactor mass, V}. The largest |v_mid|
// over continuous time, nan where the solver gives up.
extern "C" double peak_speed(
    int N, int law, const double *numbers, const double *p, double t_end, double rtol, double atol) {
    const bool hertz = law == 4 && numbers[0] == 1.5;
    switch (law) {
        case 0: return peak<Linear>(N, numbers, p, t_end, rtol, atol);
        case 1: return peak<Bistable>(N, numbers, p, t_end, rtol, atol);
        case 2: return peak<Polynomial>(N, numbers, p, t_end, rtol, atol);
        case 3: return peak<PiecewiseLinear<2>>(N, numbers, p, t_end, rtol, atol);
        case 4: return (hertz ? peak<Power<true>> : peak<Power<false>>)(N, numbers, p, t_end, rtol, atol);
        default: return peak<Toda>(N, numbers, p, t_end, rtol, atol);
    }
}

extern "C" const char *boost_version() { return BOOST_LIB_VERSION; }
