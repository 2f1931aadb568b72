#include <arpa/inet.h>
#include <gio/gio.h>
#include <netinet/in.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/hostport.h"
#include "base/log.h"
#include "bridges/target.h"

/* --- a resolver that says what the test wants ----------------------------- */

static const char *now_at[3]; /* no address: nobody knows the name */
static unsigned lookups;

typedef struct {
    GResolver base;
} FakeResolver;
typedef struct {
    GResolverClass base;
} FakeResolverClass;
static GType fake_resolver_get_type(void);
G_DEFINE_TYPE(FakeResolver, fake_resolver, G_TYPE_RESOLVER)

static void look(GResolver *resolver, const char *host, GCancellable *cancel,
                 GAsyncReadyCallback done, gpointer user)
{
    GTask *task = g_task_new(resolver, cancel, done, user);
    GList *list = NULL;
    lookups++;
    assert_string_equal(host, "vm.example");
    for (size_t i = 0; i < 3 && now_at[i]; i++) {
        list = g_list_append(list, g_inet_address_new_from_string(now_at[i]));
    }
    if (list) {
        g_task_return_pointer(task, list, NULL);
    } else {
        g_task_return_new_error(task, G_RESOLVER_ERROR,
                                G_RESOLVER_ERROR_NOT_FOUND, "no such host");
    }
    g_object_unref(task);
}

static GList *looked(GResolver *resolver, GAsyncResult *result, GError **error)
{
    (void)resolver;
    return g_task_propagate_pointer(G_TASK(result), error);
}

static void fake_resolver_class_init(FakeResolverClass *class)
{
    class->base.lookup_by_name_async = look;
    class->base.lookup_by_name_finish = looked;
}

static void fake_resolver_init(FakeResolver *resolver)
{
    (void)resolver;
}

/* --- the tests ------------------------------------------------------------ */

static void texts_are_split(void **state)
{
    (void)state;
    static const struct {
        const char *text, *host; /* NULL: refused */
        unsigned port;
    } cases[] = {
        { "127.0.0.1:1502", "127.0.0.1", 1502 },
        { "[::1]:80", "::1", 80 },
        { "localhost:0", "127.0.0.1", 0 },
        { "vm:33001", "vm", 33001 },
        { "vm-2.lab.example.:65535", "vm-2.lab.example.", 65535 },
        { "4ship:1", "4ship", 1 },
        { "vm", NULL, 0 },
        { ":80", NULL, 0 },
        { "vm:", NULL, 0 },
        { "vm:x", NULL, 0 },
        { "vm:65536", NULL, 0 },
        { "::1:80", NULL, 0 },
        { "[vm]:80", NULL, 0 },
        { "1.2.3:80", NULL, 0 },
        { "256.1.1.1:80", NULL, 0 },
        { "-vm:80", NULL, 0 },
        { "a..b:80", NULL, 0 },
        { "a b:80", NULL, 0 },
        { "http://vm:80", NULL, 0 },
    };
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        char host[PEL_HOST_SIZE];
        uint16_t port;
        bool good =
            pel_hostport_split(cases[i].text, host, &port) != PEL_HOST_NONE;
        if (good != (cases[i].host != NULL)) {
            fail_msg("%s", cases[i].text);
        }
        if (good) {
            assert_string_equal(host, cases[i].host);
            assert_int_equal(port, cases[i].port);
        }
    }
}

static struct pel_target *make(const char *text, int family)
{
    const struct pel_target_options options = { "cigi-host", text, family,
                                                NULL };
    struct pel_target *target;
    assert_int_equal(pel_target_create(&options, &target, NULL), PEL_OK);
    return target;
}

/* "": not resolved. */
static const char *place(const struct pel_target *target)
{
    static char text[64];
    socklen_t size;
    const struct sockaddr *at = pel_target_address(target, &size);
    *text = 0;
    if (at && at->sa_family == AF_INET) {
        assert_int_equal(ntohs(((const struct sockaddr_in *)at)->sin_port),
                         33001);
        inet_ntop(AF_INET, &((const struct sockaddr_in *)at)->sin_addr, text,
                  sizeof text);
    } else if (at) {
        inet_ntop(AF_INET6, &((const struct sockaddr_in6 *)at)->sin6_addr, text,
                  sizeof text);
    }
    return text;
}

static void turn_until_looked(unsigned count)
{
    while (lookups < count) {
        g_main_context_iteration(NULL, TRUE);
    }
    while (g_main_context_iteration(NULL, FALSE)) {
    }
}

static void numbers_need_nobody(void **state)
{
    (void)state;
    lookups = 0;
    struct pel_target *target = make("127.0.0.1:33001", AF_INET);
    assert_string_equal(place(target), "127.0.0.1");
    pel_target_destroy(target);
    const struct pel_target_options other = { "cigi-host", "[::1]:1", AF_INET,
                                              NULL };
    struct pel_fault fault;
    assert_int_equal(pel_target_create(&other, &target, &fault),
                     PEL_ERR_INVALID);
    assert_non_null(strstr(fault.message, "--cigi-host: '[::1]:1'"));
    assert_int_equal(lookups, 0);
}

/* Nobody knows it at first; then it is there, and later elsewhere. */
static void names_are_followed(void **state)
{
    (void)state;
    memset(now_at, 0, sizeof now_at);
    lookups = 0;
    struct pel_target *target = make("vm.example:33001", AF_INET);
    assert_string_equal(place(target), "");
    turn_until_looked(1);
    assert_string_equal(place(target), "");
    now_at[0] = "fd00::1"; /* not of the family */
    now_at[1] = "10.0.0.3";
    turn_until_looked(2); /* by itself, a second later */
    assert_string_equal(place(target), "10.0.0.3");
    /* The address in use stays while it is among them. */
    now_at[0] = "10.0.0.9";
    pel_target_failed(target);
    turn_until_looked(2); /* not so soon after the last time */
    assert_string_equal(place(target), "10.0.0.3");
    pel_target_destroy(target);
}

static void a_family_may_be_missing(void **state)
{
    (void)state;
    memset(now_at, 0, sizeof now_at);
    now_at[0] = "10.0.0.3";
    lookups = 0;
    struct pel_target *six = make("vm.example:33001", AF_INET6);
    struct pel_target *any = make("vm.example:33001", AF_UNSPEC);
    turn_until_looked(2);
    assert_string_equal(place(six), "");
    assert_string_equal(place(any), "10.0.0.3");
    pel_target_destroy(six);
    now_at[0] = "fd00::1";
    struct pel_target *new_six = make("vm.example:33001", AF_INET6);
    turn_until_looked(3);
    assert_string_equal(place(new_six), "fd00::1");
    pel_target_destroy(new_six);
    pel_target_destroy(any);
}

/* A look-up under way outlives who asked. */
static void who_is_gone_is_not_told(void **state)
{
    (void)state;
    struct pel_target *target = make("vm.example:33001", AF_INET);
    pel_target_destroy(target);
    while (g_main_context_iteration(NULL, FALSE)) {
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(texts_are_split),
        cmocka_unit_test(numbers_need_nobody),
        cmocka_unit_test(names_are_followed),
        cmocka_unit_test(a_family_may_be_missing),
        cmocka_unit_test(who_is_gone_is_not_told),
    };
    pel_log_set_level(PEL_LOG_ERROR);
    GResolver *resolver = g_object_new(fake_resolver_get_type(), NULL);
    g_resolver_set_default(resolver);
    g_object_unref(resolver);
    return cmocka_run_group_tests_name("target", tests, NULL, NULL);
}
