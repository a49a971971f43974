/* Numerical integration of smooth functions. */
#ifndef TY_BASE_QUADRATURE_H
#define TY_BASE_QUADRATURE_H

/* Integral of f(user, x) from a to b: Gauss-Legendre with eight points in each of `panels` equal intervals. */
static inline double ty_integrate(double (*f)(const void* user, double x), const void* user, double a, double b,
                                  int panels) {
    static const double node[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
    static const double weight[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
    double sum = 0;
    const double half = (b - a) / (2 * panels);
    for (int panel = 0; panel < panels; ++panel) {
        const double center = a + (2 * panel + 1) * half;
        for (int i = 0; i < 4; ++i)
            sum += weight[i] * (f(user, center - half * node[i]) + f(user, center + half * node[i]));
    }
    return sum * half;
}

#endif
