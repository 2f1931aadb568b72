/* Programs that a driver compiles while others are asked for: pictures have the
 * same bits, and one that does not compile is told of when it is waited for,
 * once; after it they are made one by one. */
#include "render/render_testkit.h"
#include "render/shader.h"

enum { SIDE = 64 };
static struct pel_sea sea;

static struct pel_picture *draw(struct pel_renderer *r)
{
    struct pel_environment env = test_environment(&sea, 5.0);
    const struct pel_camera c =
        test_camera((struct test_look){ 12, 40, -5, 0, 60, SIDE, SIDE });
    return test_draw(r, &env, &c, PEL_LAYER_COLOR);
}

static void begin_again(void)
{
    const struct pel_renderer_options options = { .device = test_device() };
    struct pel_fault fault = { 0 };
    pel_renderer_destroy(renderer);
    renderer = NULL;
    assert_int_equal(pel_renderer_create(&options, &renderer, &fault), PEL_OK);
}

/* Nobody has a binary of it. */
static enum pel_err make(const char *defines, GLuint *out,
                         struct pel_fault *fault)
{
    return pel_program_create(NULL, "clear.comp", NULL, defines, out, fault);
}

static void pictures_are_the_same(void **state)
{
    (void)state;
    /* First: the other's come from the binaries that this one leaves. */
    pel_program_side_by_side();
    struct pel_picture *p = draw(renderer);
    uint8_t bits[4 * SIDE * SIDE];
    memcpy(bits, p->rgba, sizeof bits);
    pel_picture_release(p);
    /* From the second picture on they are not. */
    pel_picture_release(draw(renderer));
    struct pel_fault fault = { 0 };
    GLuint late;
    GLint shaders = 1;
    assert_int_equal(make("#define TEST_LATE\n", &late, &fault), PEL_OK);
    glGetProgramiv(late, GL_ATTACHED_SHADERS, &shaders);
    assert_int_equal(shaders, 0);
    pel_program_delete(late);
    assert_false(pel_renderer_lost(renderer));
    begin_again();
    p = draw(renderer);
    assert_memory_equal(p->rgba, bits, sizeof bits);
    pel_picture_release(p);
    pel_program_side_by_side(); /* for the tests that follow */
}

static void some_are_used_and_deleted_before(void **state)
{
    (void)state;
    struct pel_fault fault = { 0 };
    GLuint used, deleted, settled;
    GLint ok = 0;
    const unsigned before = pel_program_count();
    assert_int_equal(make("#define TEST_USED\n", &used, &fault), PEL_OK);
    assert_int_equal(make("#define TEST_DELETED\n", &deleted, &fault), PEL_OK);
    assert_int_equal(make("#define TEST_SETTLED\n", &settled, &fault), PEL_OK);
    GLint shaders = 0;
    glGetProgramiv(settled, GL_ATTACHED_SHADERS, &shaders);
    assert_int_equal(shaders, 1); /* it is not waited for yet */
    pel_program_use(used);
    pel_program_use(0);
    pel_program_delete(deleted);
    assert_int_equal(pel_program_settle(&fault), PEL_OK);
    glGetProgramiv(settled, GL_ATTACHED_SHADERS, &shaders);
    assert_int_equal(shaders, 0); /* it was waited for */
    glGetProgramiv(settled, GL_LINK_STATUS, &ok);
    assert_true(ok);
    pel_program_delete(used);
    pel_program_delete(settled);
    assert_int_equal(pel_program_count(), before);
    assert_false(pel_program_failed());
}

static void one_that_fails_is_told_of_and_is_a_loss(void **state)
{
    (void)state;
    struct pel_fault fault = { 0 };
    GLuint bad = 0, good = 0;
    assert_int_equal(make("#error not so\n", &bad, &fault), PEL_OK);
    assert_int_equal(make("#define TEST_BESIDE\n", &good, &fault), PEL_OK);
    assert_int_not_equal(bad, 0);
    assert_false(pel_program_failed());
    assert_int_equal(pel_program_settle(&fault), PEL_ERR_GPU);
    assert_non_null(strstr(fault.message, "clear.comp does not compile"));
    assert_true(pel_renderer_lost(renderer));
    assert_int_equal(pel_program_settle(&fault), PEL_OK); /* told once */
    begin_again();
    pel_program_side_by_side();
    assert_int_equal(make("#error nor so\n", &bad, &fault), PEL_ERR_GPU);
    assert_int_equal(bad, 0);
    assert_false(pel_renderer_lost(renderer));
    pel_picture_release(draw(renderer));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_are_the_same),
        cmocka_unit_test(some_are_used_and_deleted_before),
        cmocka_unit_test(one_that_fails_is_told_of_and_is_a_loss),
    };
    test_sea(9.0, 0.0, 3, &sea);
    int failed = cmocka_run_group_tests(tests, begin_renderer, end_renderer);
    pel_sea_finish(&sea);
    return failed;
}
