/* Models: what is built in is closed, of its size, floats as ships do; rays,
 * levels of detail, refusals, memory. */
#include "models/model.h"

#include <malloc.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "models/builtin.h"
#include "models/shape.h"

static const struct pel_model *make(const char *name, double length_m)
{
    const struct pel_builtin what = { .name = name, .length_m = length_m };
    const struct pel_model *model = NULL;
    struct pel_fault fault = { 0 };
    if (pel_builtin_make(&what, &model, &fault)) {
        fail_msg("%s: %s", name, fault.message);
    }
    return model;
}

static struct pel_vec3 corner(const struct pel_model *m, size_t i)
{
    const float *p = m->vertices[m->indices[i]].position;
    return (struct pel_vec3){ (double)p[0], (double)p[1], (double)p[2] };
}

static struct pel_vec3 minus(struct pel_vec3 a, struct pel_vec3 b)
{
    return pel_vec3_add(a, pel_vec3_scale(b, -1));
}

/* Random numbers of the tests' own: xorshift. */
static double any(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return (double)(*state >> 11) / 9007199254740992.0;
}

/* --- closed
 * -------------------------------------------------------------------- */

struct edge {
    float a[3], b[3]; /* in a fixed order */
    int sign;
};

static int compare(const void *x, const void *y)
{
    return memcmp(x, y, 6 * sizeof(float));
}

static struct edge edge_of(const struct pel_model *m, uint32_t from,
                           uint32_t to)
{
    struct edge e = { .sign = 1 };
    for (int k = 0; k < 3; k++) {
        e.a[k] = m->vertices[from].position[k] + 0.0f;
        e.b[k] = m->vertices[to].position[k] + 0.0f;
    }
    if (memcmp(e.a, e.b, sizeof e.a) > 0) {
        struct edge turned = { .sign = -1 };
        memcpy(turned.a, e.b, sizeof e.a);
        memcpy(turned.b, e.a, sizeof e.a);
        return turned;
    }
    return e;
}

/* Edges that are passed more often one way than the other: holes. */
static size_t open_edges(const struct pel_model *m, int level)
{
    const struct pel_model_level *l = &m->levels[level];
    size_t count = 3 * l->triangles, open = 0;
    struct edge *edges = malloc(count * sizeof *edges);
    const uint32_t *i = m->indices + l->parts[0].first;
    for (size_t k = 0; k < count; k++) {
        edges[k] = edge_of(m, i[k], i[k % 3 == 2 ? k - 2 : k + 1]);
    }
    qsort(edges, count, sizeof *edges, compare);
    for (size_t k = 0, sum = 0; k < count; k++) {
        sum += (size_t)edges[k].sign;
        if (k + 1 == count || compare(&edges[k], &edges[k + 1]) != 0) {
            open += sum != 0;
            sum = 0;
        }
    }
    free(edges);
    return open;
}

static double volume(const struct pel_model *m)
{
    double sum = 0;
    for (size_t t = 0; t < 3 * m->levels[0].triangles; t += 3) {
        sum += pel_vec3_dot(corner(m, t), pel_vec3_cross(corner(m, t + 1),
                                                         corner(m, t + 2))) /
               6;
    }
    return sum;
}

static void test_bodies_are_closed(void **state)
{
    size_t count;
    const struct pel_builtin_kind *kinds = pel_builtin_kinds(&count);
    (void)state;
    for (size_t i = 0; i < count; i++) {
        const struct pel_model *m = make(kinds[i].name, 0);
        for (int level = 0; level < m->level_count; level++) {
            size_t open = open_edges(m, level);
            if (open > 0) {
                fail_msg("%s, level %d: %zu open edges", m->name, level, open);
            }
        }
        assert_true(volume(m) > 0);
        pel_model_unref(m);
    }
}

/* --- sizes
 * ------------------------------------------------------------------------ */

static void test_sizes_are_what_was_asked(void **state)
{
    size_t count;
    const struct pel_builtin_kind *kinds = pel_builtin_kinds(&count);
    (void)state;
    for (size_t i = 0; i < count; i++) {
        const double scales[] = { 1, 0.6, 1.7 };
        for (int k = 0; k < 3; k++) {
            double s = scales[k];
            const struct pel_model *m =
                make(kinds[i].name, s * kinds[i].length_m);
            const double got[] = { m->high.x - m->low.x, m->high.y - m->low.y,
                                   -m->low.z, m->high.z };
            const double want[] = { kinds[i].length_m * s, kinds[i].beam_m * s,
                                    kinds[i].draught_m * s,
                                    kinds[i].height_m * s };
            /* Fenders, propellers and bridge wings stand out. */
            const double less[] = { 0.95, 0.95, 0.93, 0.95 };
            const double more[] = { 1.06, 1.12, 1.06, 1.06 };
            for (int d = 0; d < 4; d++) {
                if (got[d] < less[d] * want[d] || got[d] > more[d] * want[d]) {
                    fail_msg("%s × %.1f, dimension %d: %.3f m, not %.3f",
                             m->name, s, d, got[d], want[d]);
                }
            }
            assert_float_equal(m->length_m, want[0], 1e-9);
            pel_model_unref(m);
        }
    }
}

/* Block coefficients of ships as naval architecture has them (Schneekluth and
 * Bertram 1998, tables of main dimensions), wide enough for their kinds. */
static void test_hulls_displace_what_ships_do(void **state)
{
    static const struct {
        const char *name;
        double low, high;
    } ships[] = {
        { "container-ship", 0.55, 0.75 }, { "tanker", 0.78, 0.9 },
        { "bulk-carrier", 0.75, 0.9 },    { "ferry", 0.48, 0.7 },
        { "cruise-ship", 0.5, 0.72 },     { "tug", 0.4, 0.65 },
        { "fishing-boat", 0.38, 0.62 },   { "patrol-boat", 0.33, 0.6 }
    };
    (void)state;
    for (size_t i = 0; i < sizeof ships / sizeof *ships; i++) {
        const struct pel_model *m = make(ships[i].name, 0);
        double displaced = 0, moment = 0;
        for (size_t c = 0; c < m->column_count; c++) {
            double v = -(double)(m->columns[c].bottom * m->columns[c].area);
            assert_true(v > 0);
            displaced += v;
            moment += v * (double)m->columns[c].y;
        }
        double block = displaced / (m->length_m * m->beam_m * m->draught_m);
        if (block < ships[i].low || block > ships[i].high) {
            fail_msg("%s: block coefficient %.3f, not %.2f to %.2f", m->name,
                     block, ships[i].low, ships[i].high);
        }
        /* Upright: as much to port as to starboard, but for a lattice. */
        assert_true(fabs(moment / displaced) < 0.02 * m->beam_m);
        pel_model_unref(m);
    }
}

/* --- rays
 * ------------------------------------------------------------------------- */

/* Every triangle, by Cramer's rule: shares nothing with the tree. */
static double nearest(const struct pel_model *m, struct pel_vec3 o,
                      struct pel_vec3 d)
{
    double best = INFINITY;
    for (size_t t = 0; t < 3 * m->levels[0].triangles; t += 3) {
        struct pel_vec3 a = corner(m, t);
        struct pel_vec3 e = minus(corner(m, t + 1), a);
        struct pel_vec3 f = minus(corner(m, t + 2), a), g = minus(o, a);
        struct pel_vec3 df = pel_vec3_cross(d, f);
        double det = pel_vec3_dot(e, df);
        double u = pel_vec3_dot(g, df) / det;
        double v = pel_vec3_dot(d, pel_vec3_cross(g, e)) / det;
        double at = pel_vec3_dot(f, pel_vec3_cross(g, e)) / det;
        if (det != 0 && u >= 0 && v >= 0 && u + v <= 1 && at > 0) {
            best = fmin(best, at);
        }
    }
    return best;
}

static struct pel_vec3 direction(uint64_t *seed)
{
    for (;;) {
        struct pel_vec3 v = { 2 * any(seed) - 1, 2 * any(seed) - 1,
                              2 * any(seed) - 1 };
        double l2 = pel_vec3_dot(v, v);
        if (l2 > 0.01 && l2 < 1) {
            return pel_vec3_normalize(v);
        }
    }
}

static struct pel_vec3 inside(const struct pel_model *m, uint64_t *seed)
{
    return (struct pel_vec3){ m->low.x + any(seed) * (m->high.x - m->low.x),
                              m->low.y + any(seed) * (m->high.y - m->low.y),
                              m->low.z + any(seed) * (m->high.z - m->low.z) };
}

static void test_rays_meet_the_nearest_triangle(void **state)
{
    static const char *const names[] = { "container-ship", "rib",
                                         "cardinal-east", "sailing-yacht" };
    uint64_t seed = 42;
    (void)state;
    for (size_t i = 0; i < 4; i++) {
        const struct pel_model *m = make(names[i], 0);
        int met = 0;
        for (int k = 0; k < 400; k++) {
            struct pel_vec3 d = direction(&seed);
            struct pel_vec3 o = pel_vec3_add(
                inside(m, &seed), pel_vec3_scale(d, -3 * m->radius_m));
            struct pel_model_hit hit;
            bool found = pel_model_cast(m, o, d, 1e9, &hit);
            double want = nearest(m, o, d);
            assert_int_equal(found, want < 1e9);
            if (found) {
                met++;
                assert_float_equal(hit.distance_m, want, 1e-7 * want);
                /* From outside a closed body shows its front. */
                assert_true(hit.front);
                assert_true(pel_vec3_dot(hit.normal, d) < 0);
                assert_true(hit.node < m->node_count);
            }
        }
        assert_true(met > 40);
        pel_model_unref(m);
    }
}

/* Rays exactly through vertices of the hull and along its plane of symmetry:
 * none slips between two triangles. */
static void test_rays_do_not_leak(void **state)
{
    const struct pel_model *m = make("tanker", 0);
    (void)state;
    for (size_t i = 0; i < m->vertex_count; i += 7) {
        const float *p = m->vertices[i].position;
        struct pel_model_hit hit;
        double z;
        if (p[2] > 0 || fabsf(p[1]) > 18 || fabsf(p[0]) > 100) {
            continue;
        }
        assert_true(pel_model_top(m, (double)p[0], (double)p[1], &hit, &z));
        assert_true(z >= (double)p[2] - 1e-4);
    }
    struct pel_model_hit hit;
    double z;
    assert_true(pel_model_top(m, 0, 0, &hit, &z));
    assert_true(z > 6);
    assert_false(pel_model_top(m, 0, 22, &hit, &z));
    pel_model_unref(m);
}

static void quad(struct pel_shape *shape, const float p[4][3], int paint,
                 int node)
{
    static const int corners[2][3] = { { 0, 1, 2 }, { 0, 2, 3 } };
    for (int t = 0; t < 2; t++) {
        struct pel_model_vertex v[3] = { 0 };
        for (int k = 0; k < 3; k++) {
            memcpy(v[k].position, p[corners[t][k]], sizeof v[k].position);
        }
        pel_shape_triangle(shape, v, paint, node);
    }
}

/* A narrow deck at the foot of a long wall sees half of the sky, and the wall
 * in the other half; the wall sees the sky and, but for little, the sea beyond
 * the deck's edge. */
static void test_walls_hide_half_the_sky(void **state)
{
    struct pel_shape shape = { 0 };
    struct pel_model_draft draft;
    const struct pel_model *m = NULL;
    struct pel_fault fault;
    (void)state;
    const struct pel_model_material material = { .albedo = { 0.5f, 0.5f, 0.5f },
                                                 .roughness = 1,
                                                 .texture = -1 };
    int paint = pel_shape_material(&shape, &material);
    int node = pel_shape_node(&shape, "corner");
    quad(&shape,
         (const float[4][3]){ { 0, -200, 9 },
                              { 0.1f, -200, 9 },
                              { 0.1f, 200, 9 },
                              { 0, 200, 9 } },
         paint, node);
    quad(&shape,
         (const float[4][3]){
             { 0, -400, 9 }, { 0, 400, 9 }, { 0, 400, 60 }, { 0, -400, 60 } },
         paint, node);
    assert_int_equal(pel_shape_finish(&shape, &draft, &fault), PEL_OK);
    assert_int_equal(pel_model_create(&draft.model, &m, &fault), PEL_OK);
    assert_null(m->open);
    assert_int_equal(pel_model_shade(m, &fault), PEL_OK);
    const struct pel_model_open *open = m->open;
    if (!open) {
        fail_msg("it is not shaded");
        return;
    }
    for (size_t i = 0; i < m->vertex_count; i++) {
        const struct pel_model_open *o = &open[i];
        if (m->vertices[i].normal[2] > 0.5f) {
            /* 16 rays from each corner: 1/8 is two of them. */
            assert_float_equal(o->above / 255.0, 0.5, 0.13);
            assert_float_equal(o->own_above / 255.0, 0.25, 0.07);
            assert_int_equal(o->own_below, 0);
        } else {
            assert_int_equal(o->above, 255);
            assert_true(o->below >= 200);
        }
    }
    pel_model_unref(m);
    pel_model_draft_clear(&draft);
    pel_shape_clear(&shape);
}

/* A square with a texture: its left half is a hole. */
static void test_holes_let_rays_through(void **state)
{
    const uint8_t texels[] = { 255, 255, 255, 0, 255, 255, 255, 255 };
    struct pel_shape shape = { 0 };
    struct pel_model_draft draft;
    const struct pel_model *m = NULL;
    struct pel_fault fault;
    (void)state;
    const struct pel_model_texture texture = { 2, 1, texels };
    const struct pel_model_material material = { .albedo = { 1, 1, 1 },
                                                 .roughness = 1,
                                                 .alpha_cutoff = 0.5f,
                                                 .texture = pel_shape_texture(
                                                     &shape, &texture) };
    int paint = pel_shape_material(&shape, &material);
    int node = pel_shape_node(&shape, "grating");
    const struct pel_model_vertex v[] = {
        { .position = { 0, 0, 1 }, .uv = { 0, 0 } },
        { .position = { 2, 0, 1 }, .uv = { 1, 0 } },
        { .position = { 2, 2, 1 }, .uv = { 1, 1 } },
        { .position = { 0, 2, 1 }, .uv = { 0, 1 } },
    };
    pel_shape_triangle(&shape, (struct pel_model_vertex[]){ v[0], v[1], v[2] },
                       paint, node);
    pel_shape_triangle(&shape, (struct pel_model_vertex[]){ v[0], v[2], v[3] },
                       paint, node);
    assert_int_equal(pel_shape_finish(&shape, &draft, &fault), PEL_OK);
    assert_int_equal(pel_model_create(&draft.model, &m, &fault), PEL_OK);
    struct pel_model_hit hit;
    double z;
    assert_true(pel_model_top(m, 1.5, 1, &hit, &z));
    assert_float_equal(z, 1, 1e-9);
    assert_string_equal(m->nodes[hit.node], "grating");
    assert_false(pel_model_top(m, 0.5, 1, &hit, &z));
    /* Normals are made where there were none. */
    assert_float_equal((double)m->vertices[0].normal[2], 1, 1e-6);
    pel_model_unref(m);
    pel_model_draft_clear(&draft);
    pel_shape_clear(&shape);
}

/* --- levels
 * ------------------------------------------------------------------------- */

static double to_segment(struct pel_vec3 p, struct pel_vec3 a,
                         struct pel_vec3 b)
{
    struct pel_vec3 ab = minus(b, a), ap = minus(p, a);
    double t = pel_clamp(
        pel_vec3_dot(ap, ab) / fmax(pel_vec3_dot(ab, ab), 1e-300), 0, 1);
    struct pel_vec3 d = minus(ap, pel_vec3_scale(ab, t));
    return sqrt(pel_vec3_dot(d, d));
}

static double to_triangle(struct pel_vec3 p, const struct pel_vec3 c[3])
{
    struct pel_vec3 n = pel_vec3_cross(minus(c[1], c[0]), minus(c[2], c[0]));
    double l = sqrt(pel_vec3_dot(n, n)), best = INFINITY;
    bool within = l > 0;
    for (int k = 0; k < 3; k++) {
        struct pel_vec3 side = minus(c[(k + 1) % 3], c[k]);
        within = within &&
                 pel_vec3_dot(pel_vec3_cross(side, minus(p, c[k])), n) >= 0;
        best = fmin(best, to_segment(p, c[k], c[(k + 1) % 3]));
    }
    return within ? fabs(pel_vec3_dot(n, minus(p, c[0]))) / l : best;
}

static double to_level(const struct pel_model *m, int level, struct pel_vec3 p)
{
    double best = INFINITY;
    size_t first = m->levels[level].parts[0].first;
    for (size_t t = 0; t < m->levels[level].triangles; t++) {
        const struct pel_vec3 c[] = { corner(m, first + 3 * t),
                                      corner(m, first + 3 * t + 1),
                                      corner(m, first + 3 * t + 2) };
        best = fmin(best, to_triangle(p, c));
    }
    return best;
}

static void test_levels_stay_within_their_error(void **state)
{
    size_t count;
    const struct pel_builtin_kind *kinds = pel_builtin_kinds(&count);
    (void)state;
    for (size_t i = 0; i < count; i++) {
        const struct pel_model *m = make(kinds[i].name, 0);
        assert_true(m->level_count >= 2);
        for (int l = 1; l < m->level_count; l++) {
            double worst = 0, error_m = (double)m->levels[l].error_m;
            assert_true(m->levels[l].triangles <=
                        m->levels[l - 1].triangles * 2 / 3);
            assert_true(error_m >= (double)m->levels[l - 1].error_m);
            size_t step = m->vertex_count / 150 + 1;
            for (size_t v = 0; v < m->vertex_count; v += step) {
                const float *p = m->vertices[v].position;
                worst =
                    fmax(worst,
                         to_level(m, l,
                                  (struct pel_vec3){ (double)p[0], (double)p[1],
                                                     (double)p[2] }));
            }
            /* What vanished whole is as far away as what is left is. */
            if (l == 1 && worst > error_m + 1e-4) {
                fail_msg("%s, level %d: %.3f m from it, more than %.3f",
                         m->name, l, worst, error_m);
            }
        }
        assert_int_equal(pel_model_level_for(m, 1e9, 1), 0);
        assert_int_equal(pel_model_level_for(m, 1e-9, 1), m->level_count - 1);
        pel_model_unref(m);
    }
}

/* --- refusals, memory
 * ------------------------------------------------------------------ */

static void test_refusals_say_what_is_wrong(void **state)
{
    const struct pel_model *m = NULL;
    struct pel_fault fault = { 0 };
    (void)state;
    struct pel_builtin what = { .name = "submarine" };
    assert_int_equal(pel_builtin_make(&what, &m, &fault), PEL_ERR_NOT_FOUND);
    assert_non_null(strstr(fault.message, "submarine"));
    what = (struct pel_builtin){ .name = "tug", .draught_m = 60 };
    assert_int_equal(pel_builtin_make(&what, &m, &fault), PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.path, "draught");
    what = (struct pel_builtin){ .name = "tug", .length_m = NAN };
    assert_int_equal(pel_builtin_make(&what, &m, &fault), PEL_ERR_OUT_OF_RANGE);
    assert_null(m);
    struct pel_shape empty = { 0 };
    struct pel_model_draft draft;
    assert_int_equal(pel_shape_finish(&empty, &draft, &fault), PEL_ERR_INVALID);
}

/* A draft with one number spoilt at a time is refused, whichever it is. */
static void test_drafts_are_not_trusted(void **state)
{
    const struct pel_model *good = make("special-mark", 0), *m = NULL;
    struct pel_fault fault;
    (void)state;
    for (int i = 0; i < 9; i++) {
        struct pel_model bad = *good;
        uint32_t *indices = malloc(bad.index_count * sizeof *indices);
        struct pel_model_vertex *vertices =
            malloc(bad.vertex_count * sizeof *vertices);
        struct pel_model_part part = bad.levels[0].parts[0];
        struct pel_model_material materials[PEL_MODEL_MOST_MATERIALS];
        memcpy(indices, bad.indices, bad.index_count * sizeof *indices);
        memcpy(vertices, bad.vertices, bad.vertex_count * sizeof *vertices);
        memcpy(materials, bad.materials,
               bad.material_count * sizeof *materials);
        bad.indices = indices;
        bad.vertices = vertices;
        bad.materials = materials;
        indices[5] = i == 0 ? (uint32_t)bad.vertex_count : indices[5];
        vertices[3].position[1] = i == 1 ? NAN : vertices[3].position[1];
        vertices[3].normal[1] = i == 2 ? 9 : vertices[3].normal[1];
        materials[1].texture = i == 3 ? 0 : -1;
        materials[0].roughness = i == 4 ? -1 : 0.5f;
        bad.level_count = i == 5 ? 77 : bad.level_count;
        bad.levels[0].triangles += i == 6;
        part.first = i == 7 ? 3 : 0;
        if (i == 7) {
            bad.levels[0].parts = &part;
        }
        bad.length_m = i == 8 ? INFINITY : bad.length_m;
        assert_int_not_equal(pel_model_create(&bad, &m, &fault), PEL_OK);
        assert_null(m);
        free(indices);
        free(vertices);
    }
    pel_model_unref(good);
}

/* Nothing of the ship is close before them, ahead and to 40 degrees. */
static void test_eyes_look_out(void **state)
{
    (void)state;
    size_t count, eyes = 0;
    const struct pel_builtin_kind *kinds = pel_builtin_kinds(&count);
    for (size_t i = 0; i < count; i++) {
        const struct pel_model *m = make(kinds[i].name, 0);
        for (size_t e = 0; e < m->eye_count; e++, eyes++) {
            for (int turn = -40; turn <= 40; turn += 10) {
                double a = turn * PEL_DEG;
                struct pel_model_hit hit;
                if (pel_model_cast(m, m->eyes[e].at,
                                   (struct pel_vec3){ cos(a), sin(a), 0 }, 1,
                                   &hit)) {
                    fail_msg("%s, %s: %.2f m at %d degrees", kinds[i].name,
                             m->eyes[e].name, hit.distance_m, turn);
                }
            }
        }
        pel_model_unref(m);
    }
    assert_true(eyes >= 10);
}

static void test_models_leave_no_memory_behind(void **state)
{
    size_t before = 0;
    (void)state;
    for (int i = 0; i < 1000; i++) {
        const struct pel_model *m = make("cardinal-west", 0);
        pel_model_unref(pel_model_ref(m));
        pel_model_unref(m);
        if (i == 10) {
            before = mallinfo2().uordblks;
        }
    }
    assert_true(mallinfo2().uordblks <= before);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bodies_are_closed),
        cmocka_unit_test(test_sizes_are_what_was_asked),
        cmocka_unit_test(test_hulls_displace_what_ships_do),
        cmocka_unit_test(test_rays_meet_the_nearest_triangle),
        cmocka_unit_test(test_rays_do_not_leak),
        cmocka_unit_test(test_walls_hide_half_the_sky),
        cmocka_unit_test(test_holes_let_rays_through),
        cmocka_unit_test(test_levels_stay_within_their_error),
        cmocka_unit_test(test_refusals_say_what_is_wrong),
        cmocka_unit_test(test_drafts_are_not_trusted),
        cmocka_unit_test(test_eyes_look_out),
        cmocka_unit_test(test_models_leave_no_memory_behind),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
