/* The force loop of evodevo_sim.physics once more in plain C, as a yardstick: springs, damping, chambers and drag.
   `passes` walks as the library's kernel does, `plain` writes the laws down term by term.  Indices as in evodevo_sim.body. */

#include <math.h>
#include <stdint.h>

typedef struct {
    int64_t cells, springs, triangles, polygons, outlines;
    const double *inverse_mass, *triangle_area, *polygon_area, *rest;
    const uint32_t *a, *b, *left, *right, *triangle, *polygon_start, *polygon_cell, *outline;
    double stiffness, damping, pressure, drag_normal, drag_tangential;
    double *edge, *push; /* scratch: (4, springs), (triangles + polygons + 1), whose last is 0 */
} Body;

static double polygon_area(const Body *q, int64_t p, const double *x, const double *y) {
    uint32_t first = q->polygon_start[p], last = q->polygon_start[p + 1], before = q->polygon_cell[last - 1];
    double ox = x[before], oy = y[before], twice = 0.0;
    for (uint32_t k = first; k < last; k++) {
        uint32_t here = q->polygon_cell[k];
        twice += (x[before] - ox) * (y[here] - oy) - (x[here] - ox) * (y[before] - oy);
        before = here;
    }
    return 0.5 * twice;
}

static void chambers(const Body *q, const double *x, const double *y) {
    double half = 0.5 * q->pressure;
    for (int64_t t = 0; t < q->triangles; t++) {
        uint32_t a = q->triangle[3 * t], b = q->triangle[3 * t + 1], c = q->triangle[3 * t + 2];
        double twice = (x[b] - x[a]) * (y[c] - y[a]) - (x[c] - x[a]) * (y[b] - y[a]);
        q->push[t] = half * (1.0 - 0.5 * twice / q->triangle_area[t]);
    }
    for (int64_t p = 0; p < q->polygons; p++)
        q->push[q->triangles + p] = half * (1.0 - polygon_area(q, p, x, y) / q->polygon_area[p]);
}

static void accelerate(const Body *q, double *ax, double *ay) {
    for (int64_t i = 0; i < q->cells; i++) {
        ax[i] *= q->inverse_mass[i];
        ay[i] *= q->inverse_mass[i];
    }
}

static __attribute__((noinline)) void passes(const Body *q, const double *x, const double *y, const double *u, const double *v,
                                             double *restrict ax, double *restrict ay) {
    int64_t springs = q->springs;
    double *restrict dx = q->edge, *restrict dy = dx + springs, *restrict inverse_square = dy + springs, *restrict pull = inverse_square + springs;
    chambers(q, x, y);
    for (int64_t e = 0; e < springs; e++) {
        uint32_t i = q->a[e], j = q->b[e];
        dx[e] = x[j] - x[i];
        dy[e] = y[j] - y[i];
        inverse_square[e] = dx[e] * dx[e] + dy[e] * dy[e];
        pull[e] = (u[j] - u[i]) * dx[e] + (v[j] - v[i]) * dy[e];
    }
    for (int64_t e = 0; e < springs; e++) {
        double inverse = 1.0 / sqrt(inverse_square[e]);
        inverse_square[e] = inverse * inverse;
        pull[e] = q->stiffness * (1.0 - q->rest[e] * inverse) + q->damping * inverse_square[e] * pull[e];
    }
    for (int64_t i = 0; i < q->cells; i++) ax[i] = ay[i] = 0.0;
    for (int64_t e = 0; e < springs; e++) {
        uint32_t i = q->a[e], j = q->b[e];
        double across = q->push[q->right[e]] - q->push[q->left[e]];
        double fx = pull[e] * dx[e], fy = pull[e] * dy[e], gx = -across * dy[e], gy = across * dx[e];
        ax[i] += gx + fx;
        ay[i] += gy + fy;
        ax[j] += gx - fx;
        ay[j] += gy - fy;
    }
    for (int64_t m = 0; m < q->outlines; m++) {
        uint32_t e = q->outline[m], i = q->a[e], j = q->b[e];
        double ue = 0.5 * (u[i] + u[j]), ve = 0.5 * (v[i] + v[j]);
        double along = ue * dx[e] + ve * dy[e], across = ve * dx[e] - ue * dy[e];
        double t = -0.5 * q->drag_tangential * inverse_square[e] * along * fabs(along);
        double n = -0.5 * q->drag_normal * inverse_square[e] * across * fabs(across);
        double fx = t * dx[e] - n * dy[e], fy = t * dy[e] + n * dx[e];
        ax[i] += fx;
        ay[i] += fy;
        ax[j] += fx;
        ay[j] += fy;
    }
    accelerate(q, ax, ay);
}

static __attribute__((noinline)) void plain(const Body *q, const double *x, const double *y, const double *u, const double *v,
                                            double *restrict ax, double *restrict ay) {
    for (int64_t i = 0; i < q->cells; i++) ax[i] = ay[i] = 0.0;
    chambers(q, x, y);
    for (int64_t e = 0; e < q->springs; e++) {
        uint32_t i = q->a[e], j = q->b[e];
        double dx = x[j] - x[i], dy = y[j] - y[i], inverse = 1.0 / sqrt(dx * dx + dy * dy);
        double rate = ((u[j] - u[i]) * dx + (v[j] - v[i]) * dy) * inverse;
        double f = (q->stiffness * (1.0 / inverse - q->rest[e]) + q->damping * rate) * inverse;
        double across = q->push[q->right[e]] - q->push[q->left[e]];
        ax[i] += f * dx - across * dy;
        ay[i] += f * dy + across * dx;
        ax[j] -= f * dx + across * dy;
        ay[j] -= f * dy - across * dx;
    }
    for (int64_t m = 0; m < q->outlines; m++) {
        uint32_t e = q->outline[m], i = q->a[e], j = q->b[e];
        double dx = x[j] - x[i], dy = y[j] - y[i], inverse = 1.0 / (dx * dx + dy * dy);
        double ue = 0.5 * (u[i] + u[j]), ve = 0.5 * (v[i] + v[j]);
        double along = ue * dx + ve * dy, across = ve * dx - ue * dy;
        double t = -0.5 * q->drag_tangential * inverse * along * fabs(along), n = -0.5 * q->drag_normal * inverse * across * fabs(across);
        double fx = t * dx - n * dy, fy = t * dy + n * dx;
        ax[i] += fx;
        ay[i] += fy;
        ax[j] += fx;
        ay[j] += fy;
    }
    accelerate(q, ax, ay);
}

void many(const Body *q, int32_t in_passes, const double *position, const double *velocity, double *out, int64_t calls) {
    int64_t n = q->cells;
    for (int64_t k = 0; k < calls; k++) {
        (in_passes ? passes : plain)(q, position, position + n, velocity, velocity + n, out, out + n);
        __asm__ volatile("" ::: "memory");
    }
}
