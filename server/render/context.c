#include "render/context.h"

#include <dlfcn.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <errno.h>
#include <limits.h>
#include <link.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/log.h"
#include "render/shader.h"

#define MAX_DEVICES 32 /* as many displays, and one without a device */

static bool has_word(const char *list, const char *word)
{
    size_t length = strlen(word);
    for (const char *at = list; at && (at = strstr(at, word)); at += length) {
        bool starts = at == list || at[-1] == ' ';
        if (starts && (at[length] == ' ' || at[length] == 0)) {
            return true;
        }
    }
    return false;
}

static bool is_software(EGLDeviceEXT device)
{
    return has_word(eglQueryDeviceStringEXT(device, EGL_EXTENSIONS),
                    "EGL_MESA_device_software");
}

static EGLDisplay open_device(EGLDeviceEXT device)
{
    EGLDisplay display =
        eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, NULL);
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, NULL, NULL)) {
        return EGL_NO_DISPLAY;
    }
    return display;
}

static EGLint list_devices(EGLDeviceEXT devices[MAX_DEVICES])
{
    /* The first is all of the second and more; NVIDIA names only that. */
    bool tells =
        epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_base") ||
        epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration");
    EGLint count = 0;
    return tells && eglQueryDevicesEXT(MAX_DEVICES, devices, &count) ? count
                                                                     : 0;
}

static EGLDisplay find_display(const char *wanted, struct pel_fault *fault)
{
    EGLDeviceEXT devices[MAX_DEVICES];
    EGLint count = list_devices(devices);
    char *end = NULL;
    long number = strtol(wanted, &end, 10);
    bool numbered = *wanted && *end == 0;
    if (numbered && (number < 0 || number >= count)) {
        pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                      "device %ld: this machine has EGL devices 0 to %d",
                      number, count - 1);
        return EGL_NO_DISPLAY;
    }
    bool only_software = strcmp(wanted, "software") == 0;
    /* Hardware first, then software, unless one is named. */
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < count; i++) {
            bool software = is_software(devices[i]);
            if (numbered ? i != number
                         : software != (only_software || pass == 1)) {
                continue;
            }
            EGLDisplay display = open_device(devices[i]);
            if (display != EGL_NO_DISPLAY) {
                return display;
            }
            pel_debug("RND-003", "EGL device %d does not initialise (0x%x)", i,
                      eglGetError());
        }
    }
    if (!numbered && epoxy_has_egl_extension(EGL_NO_DISPLAY,
                                             "EGL_MESA_platform_surfaceless")) {
        EGLDisplay display = eglGetPlatformDisplayEXT(
            EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
        if (display != EGL_NO_DISPLAY && eglInitialize(display, NULL, NULL)) {
            return display;
        }
    }
    pel_fault_set(fault, PEL_ERR_GPU,
                  "no EGL device (asked for '%s'); install libgl1-mesa-dri and "
                  "libegl-mesa0 for the software device",
                  wanted);
    return EGL_NO_DISPLAY;
}

/* Contexts of one device have one display, which ends with the last. */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct {
    EGLDisplay display;
    unsigned users;
} displays[MAX_DEVICES + 2];

static EGLDisplay open_display(const char *wanted, struct pel_fault *fault)
{
    pthread_mutex_lock(&lock);
    EGLDisplay display = find_display(wanted, fault);
    size_t i = 0;
    while (display != EGL_NO_DISPLAY && displays[i].users > 0 &&
           displays[i].display != display) {
        i++;
    }
    if (display != EGL_NO_DISPLAY) {
        displays[i].display = display;
        displays[i].users++;
    }
    pthread_mutex_unlock(&lock);
    return display;
}

static void close_display(EGLDisplay display)
{
    size_t i = 0, last = 0;
    pthread_mutex_lock(&lock);
    while (displays[i].display != display) {
        i++;
    }
    for (last = i; displays[last + 1].users > 0; last++) {
    }
    if (--displays[i].users == 0) {
        eglTerminate(display);
        displays[i] = displays[last];
        displays[last].users = 0;
        displays[last].display = EGL_NO_DISPLAY;
    }
    pthread_mutex_unlock(&lock);
}

size_t pel_context_hardware(unsigned *numbers, size_t most)
{
    EGLDeviceEXT devices[MAX_DEVICES];
    EGLint count = list_devices(devices);
    size_t found = 0;
    for (int i = 0; i < count && found < most; i++) {
        char number[16];
        snprintf(number, sizeof number, "%d", i);
        EGLDisplay display = is_software(devices[i])
                                 ? EGL_NO_DISPLAY
                                 : open_display(number, NULL);
        if (display != EGL_NO_DISPLAY) {
            numbers[found++] = (unsigned)i;
            close_display(display);
        }
    }
    return found;
}

static void APIENTRY on_message(GLenum source, GLenum type, GLuint id,
                                GLenum severity, GLsizei length,
                                const GLchar *message, const void *user)
{
    (void)source, (void)id, (void)length, (void)user;
    if (type == GL_DEBUG_TYPE_ERROR) {
        pel_error("RND-004", "OpenGL: %s", message);
    } else if (severity == GL_DEBUG_SEVERITY_HIGH) {
        pel_warn("RND-005", "OpenGL: %s", message);
    } else if (severity != GL_DEBUG_SEVERITY_NOTIFICATION) {
        pel_debug("RND-006", "OpenGL: %s", message);
    }
}

static int find_driver(struct dl_phdr_info *info, size_t size, void *path)
{
    (void)size;
    if (!strstr(info->dlpi_name, "/dri/")) {
        return 0;
    }
    snprintf(path, PATH_MAX, "%s", info->dlpi_name);
    return 1;
}

/* Mesa's driver, once loaded, stays: unloading it with the context would leak
 * what its globals hold, each time a renderer is made anew. */
static void pin_driver(void)
{
    char path[PATH_MAX];
    if (dl_iterate_phdr(find_driver, path) == 1) {
        (void)dlopen(path, RTLD_LAZY | RTLD_NOLOAD | RTLD_NODELETE);
    }
}

/* NVIDIA's driver says nothing where it has no place for compiled shaders, and
 * compiles in the first picture of each context. */
static void look_for_cache(void)
{
    static atomic_flag told = ATOMIC_FLAG_INIT;
    const char *vendor = (const char *)glGetString(GL_VENDOR);
    const char *own = getenv("XDG_CACHE_HOME");
    const char *home = own ? own : getenv("HOME");
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s%s", home ? home : "", own ? "" : "/.cache");
    if (vendor && strncmp(vendor, "NVIDIA", 6) == 0 &&
        access(path, W_OK | X_OK) != 0 && !atomic_flag_test_and_set(&told)) {
        pel_warn("RND-045",
                 "the driver cannot keep compiled shaders, as %s %s: each "
                 "start and each loss of the device takes seconds more; set "
                 "XDG_CACHE_HOME to a directory that can be written",
                 path, errno == ENOENT ? "is not there" : "cannot be written");
    }
}

enum pel_err pel_context_init(struct pel_context *context, const char *device,
                              bool debug, struct pel_fault *fault)
{
    *context = (struct pel_context){ 0 };
    EGLDisplay display = open_display(device ? device : "auto", fault);
    if (display == EGL_NO_DISPLAY) {
        return fault ? fault->code : PEL_ERR_GPU;
    }
    context->display = display;
    static const EGLint config_attributes[] = { EGL_SURFACE_TYPE, 0,
                                                EGL_RENDERABLE_TYPE,
                                                EGL_OPENGL_BIT, EGL_NONE };
    EGLConfig config = EGL_NO_CONFIG_KHR;
    EGLint configs = 0;
    if (!eglChooseConfig(display, config_attributes, &config, 1, &configs) ||
        configs == 0) {
        config = EGL_NO_CONFIG_KHR;
    }
    eglBindAPI(EGL_OPENGL_API);
    /* Where the driver cannot tell of a loss, without. */
    for (int told = epoxy_egl_version(display) >= 15; told >= 0; told--) {
        const EGLint attributes[] = {
            EGL_CONTEXT_MAJOR_VERSION,
            4,
            EGL_CONTEXT_MINOR_VERSION,
            5,
            EGL_CONTEXT_OPENGL_PROFILE_MASK,
            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
            EGL_CONTEXT_OPENGL_DEBUG,
            debug ? EGL_TRUE : EGL_FALSE,
            told ? EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY : EGL_NONE,
            EGL_LOSE_CONTEXT_ON_RESET,
            EGL_NONE,
        };
        context->context =
            eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
        context->tells_loss = told && context->context != EGL_NO_CONTEXT;
        if (context->context != EGL_NO_CONTEXT) {
            break;
        }
    }
    if (context->context == EGL_NO_CONTEXT ||
        !eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE,
                        context->context)) {
        EGLint code = eglGetError();
        pel_context_finish(context);
        return pel_fault_set(fault, PEL_ERR_GPU,
                             "no OpenGL 4.5 core context without a surface "
                             "(EGL error 0x%x)",
                             code);
    }
    pin_driver();
    look_for_cache();
    const char *renderer = (const char *)glGetString(GL_RENDERER);
    snprintf(context->description, sizeof context->description, "%s, OpenGL %s",
             renderer, (const char *)glGetString(GL_VERSION));
    context->software =
        strstr(renderer, "llvmpipe") || strstr(renderer, "softpipe");
    if (!context->software && device && strcmp(device, "software") == 0) {
        /* Other drivers offer a platform of Mesa's, too. */
        pel_context_finish(context);
        return pel_fault_set(fault, PEL_ERR_GPU,
                             "no software device; install libgl1-mesa-dri and "
                             "libegl-mesa0");
    }
    glEnable(GL_DEBUG_OUTPUT);
    if (debug) {
        glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    }
    glDebugMessageCallback(on_message, NULL);
    if (context->software && strcmp(device ? device : "auto", "auto") == 0) {
        pel_warn("RND-001",
                 "no graphics hardware found: drawing on the "
                 "processor (%s)",
                 context->description);
    } else {
        pel_info("RND-002", "drawing on %s", context->description);
    }
    return PEL_OK;
}

bool pel_context_lost(const struct pel_context *context)
{
    return context->tells_loss && glGetGraphicsResetStatus() != GL_NO_ERROR;
}

void pel_context_finish(struct pel_context *context)
{
    pel_program_forget_all();
    if (context->display) {
        eglMakeCurrent(context->display, EGL_NO_SURFACE, EGL_NO_SURFACE,
                       EGL_NO_CONTEXT);
        if (context->context) {
            eglDestroyContext(context->display, context->context);
        }
        close_display(context->display);
    }
    *context = (struct pel_context){ 0 };
}
