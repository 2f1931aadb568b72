#include "models/reader/meshfile.h"

#include <dirent.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include <assimp/GltfMaterial.h>
#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "base/file.h"

#define MOST_DEPTH 64
#define MOST_PICTURE ((size_t)64 << 20) /* bytes of a texture's file */
#define TEXTURE_SIDE 2048

/* A file on its way in. */
struct import {
    const struct pel_mesh_request *request;
    const struct aiScene *scene;
    struct pel_shape *shape;
    struct pel_mesh_notes *notes;
    bool gltf;
    int *materials; /* of the scene's, in the shape; -1: not made yet */
    struct {
        char name[256];
        int texture; /* -1: not to be had */
    } pictures[PEL_MODEL_MOST_TEXTURES];
    int picture_count;
    size_t texels;
};

/* --- textures
 * ------------------------------------------------------------------- */

/* The file `name` means, seen from the mesh's own folder: itself, or one of its
 * last part in that folder, whatever the case of its letters. */
static bool find_picture(const struct import *in, const char *name,
                         char out[4096])
{
    char folder[2048];
    snprintf(folder, sizeof folder, "%.2000s", in->request->path);
    *strrchr(folder, '/') = '\0';
    char plain[256];
    snprintf(plain, sizeof plain, "%.255s", name);
    for (char *p = plain; *p; p++) {
        *p = *p == '\\' ? '/' : *p;
    }
    int fd;
    snprintf(out, 4096, "%s/%s", folder, plain);
    if (plain[0] != '/' && pel_file_open_in(".", out, &fd, NULL) == PEL_OK) {
        close(fd);
        return true;
    }
    const char *last = strrchr(plain, '/') ? strrchr(plain, '/') + 1 : plain;
    DIR *listing = opendir(folder);
    bool found = false;
    for (struct dirent *e; listing && !found && (e = readdir(listing));) {
        found = strcasecmp(e->d_name, last) == 0;
        if (found) {
            snprintf(out, 4096, "%s/%s", folder, e->d_name);
        }
    }
    if (listing) {
        closedir(listing);
    }
    return found;
}

/* A picture in the file itself, "*3". */
static const struct aiTexture *embedded(const struct import *in,
                                        const char *name)
{
    unsigned number =
        name[0] == '*' ? (unsigned)strtoul(name + 1, NULL, 10) : 0;
    if (name[0] == '*') {
        return number < in->scene->mNumTextures ? in->scene->mTextures[number]
                                                : NULL;
    }
    for (unsigned i = 0; i < in->scene->mNumTextures; i++) {
        const struct aiTexture *t = in->scene->mTextures[i];
        if (t->mFilename.length > 0 && strcmp(t->mFilename.data, name) == 0) {
            return t;
        }
    }
    return NULL;
}

static enum pel_err decode(struct import *in, const char *name, int *out,
                           struct pel_fault *fault)
{
    const struct aiTexture *inside = embedded(in, name);
    struct pel_model_texture texture;
    char path[4096], *bytes = NULL;
    const uint8_t *from = NULL;
    size_t size = 0;
    *out = -1;
    if (inside && inside->mHeight > 0) {
        pel_mesh_note(in->notes, "a texture of raw pixels was left out");
        return PEL_OK;
    }
    if (inside) {
        from = (const uint8_t *)inside->pcData;
        size = inside->mWidth;
    } else if (!find_picture(in, name, path)) {
        pel_mesh_note(in->notes, "the texture %.80s is not there", name);
        return PEL_OK;
    } else if (pel_file_read_in(".", path, MOST_PICTURE, &bytes, &size,
                                fault)) {
        pel_mesh_note(in->notes, "the texture %.80s: %.80s", name,
                      fault->message);
        return PEL_OK;
    } else {
        from = (const uint8_t *)bytes;
    }
    int most = TEXTURE_SIDE;
    while ((size_t)most * (size_t)most > PEL_MODEL_MOST_TEXELS - in->texels) {
        most /= 2;
    }
    enum pel_err err = pel_picture_read(from, size, most, &texture, fault);
    free(bytes);
    if (err == PEL_ERR_INVALID) {
        pel_mesh_note(in->notes, "the texture %.80s was left out: %.80s", name,
                      fault->message);
        return PEL_OK;
    }
    if (!err) {
        in->texels += (size_t)texture.width * (size_t)texture.height;
        *out = pel_shape_texture(in->shape, &texture);
    }
    return err;
}

static enum pel_err take_picture(struct import *in, const char *name, int *out,
                                 struct pel_fault *fault)
{
    for (int i = 0; i < in->picture_count; i++) {
        if (strcmp(in->pictures[i].name, name) == 0) {
            *out = in->pictures[i].texture;
            return PEL_OK;
        }
    }
    *out = -1;
    if (in->picture_count == PEL_MODEL_MOST_TEXTURES) {
        pel_mesh_note(in->notes, "only the first %d textures were taken",
                      PEL_MODEL_MOST_TEXTURES);
        return PEL_OK;
    }
    enum pel_err err = decode(in, name, out, fault);
    int i = in->picture_count++;
    snprintf(in->pictures[i].name, sizeof in->pictures[i].name, "%.255s", name);
    in->pictures[i].texture = *out;
    return err;
}

/* --- materials
 * -------------------------------------------------------------------- */

static float clamped(float v, float low, float high)
{
    return v >= low ? v <= high ? v : high : low; /* NaN: low */
}

static float from_srgb(float v)
{
    v = clamped(v, 0, 1);
    return v <= 0.04045f ? v / 12.92f : powf((v + 0.055f) / 1.055f, 2.4f);
}

static float one_float(const struct aiMaterial *m, const char *key, float value)
{
    float got = value;
    unsigned count = 1;
    return aiGetMaterialFloatArray(m, key, 0, 0, &got, &count) ==
                   aiReturn_SUCCESS
               ? got
               : value;
}

static void colour_of(const struct import *in, const struct aiMaterial *m,
                      bool textured, float out[3])
{
    struct aiColor4D c = { 0.6f, 0.6f, 0.6f, 1 };
    bool base =
        aiGetMaterialColor(m, AI_MATKEY_BASE_COLOR, &c) == aiReturn_SUCCESS;
    if (!base && aiGetMaterialColor(m, AI_MATKEY_COLOR_DIFFUSE, &c) !=
                     aiReturn_SUCCESS) {
        c = (struct aiColor4D){ 0.6f, 0.6f, 0.6f, 1 };
    }
    const float rgb[] = { c.r, c.g, c.b };
    /* Exporters that write a texture often leave the colour black. */
    bool black = textured && !in->gltf && c.r + c.g + c.b < 0.01f;
    for (int k = 0; k < 3; k++) {
        out[k] = black      ? 1
                 : in->gltf ? clamped(rgb[k], 0, 1)
                            : from_srgb(rgb[k]);
    }
}

/* Whether a picture has holes: texels that are nearly transparent. */
static bool has_holes(const struct pel_model_texture *t)
{
    size_t holes = 0, count = (size_t)t->width * (size_t)t->height;
    for (size_t i = 0; i < count; i++) {
        holes += t->rgba[4 * i + 3] < 64;
    }
    return holes * 100 > count;
}

static void set_surface(const struct import *in, const struct aiMaterial *m,
                        struct pel_model_material *out)
{
    float shine = one_float(m, "$mat.shininess", 0);
    float rough = shine > 0 ? sqrtf(sqrtf(2 / (shine + 2))) : 0.6f;
    struct aiString mode = { 0 };
    int sided = 0;
    unsigned one = 1;
    out->metallic = clamped(one_float(m, "$mat.metallicFactor", 0), 0, 1);
    out->roughness =
        clamped(one_float(m, "$mat.roughnessFactor", rough), 0.05f, 1);
    aiGetMaterialIntegerArray(m, AI_MATKEY_TWOSIDED, &sided, &one);
    /* Other formats do not say, and their triangles turn either way. */
    out->two_sided = !in->gltf || sided;
    bool masked = aiGetMaterialString(m, AI_MATKEY_GLTF_ALPHAMODE, &mode) ==
                      aiReturn_SUCCESS &&
                  strcmp(mode.data, "OPAQUE") != 0;
    if (out->texture >= 0 &&
        (in->gltf ? masked : has_holes(&in->shape->textures[out->texture]))) {
        out->alpha_cutoff =
            clamped(one_float(m, "$mat.gltf.alphaCutoff", 0.5f), 0.01f, 1);
    }
}

static enum pel_err make_material(struct import *in, unsigned index, int *out,
                                  struct pel_fault *fault)
{
    const struct aiMaterial *m = in->scene->mMaterials[index];
    struct pel_model_material material = { .texture = -1 };
    struct aiString name = { 0 };
    enum pel_err err = PEL_OK;
    if (aiGetMaterialString(m, AI_MATKEY_NAME, &name) == aiReturn_SUCCESS) {
        snprintf(material.name, sizeof material.name, "%.60s", name.data);
    }
    const enum aiTextureType types[] = { aiTextureType_BASE_COLOR,
                                         aiTextureType_DIFFUSE };
    for (int i = 0; i < 2 && material.texture < 0 && !err; i++) {
        struct aiString file = { 0 };
        if (aiGetMaterialTexture(m, types[i], 0, &file, NULL, NULL, NULL, NULL,
                                 NULL, NULL) == aiReturn_SUCCESS) {
            err = take_picture(in, file.data, &material.texture, fault);
        }
    }
    colour_of(in, m, material.texture >= 0, material.albedo);
    set_surface(in, m, &material);
    *out = pel_shape_material(in->shape, &material);
    return err;
}

/* --- triangles
 * ------------------------------------------------------------------------ */

static struct pel_model_vertex corner(const struct aiMesh *mesh, unsigned i,
                                      const struct aiMatrix4x4 *to,
                                      const struct aiMatrix3x3 *turn)
{
    struct aiVector3D p = mesh->mVertices[i], n = { 0, 0, 0 };
    struct pel_model_vertex v = { 0 };
    aiTransformVecByMatrix4(&p, to);
    if (mesh->mNormals) {
        n = mesh->mNormals[i];
        aiTransformVecByMatrix3(&n, turn);
    }
    const float at[] = { p.x, p.y, p.z }, normal[] = { n.x, n.y, n.z };
    memcpy(v.position, at, sizeof at);
    memcpy(v.normal, normal, sizeof normal);
    if (mesh->mTextureCoords[0]) {
        v.uv[0] = mesh->mTextureCoords[0][i].x;
        v.uv[1] = mesh->mTextureCoords[0][i].y;
    }
    return v;
}

static bool is_number(const struct pel_model_vertex *v)
{
    bool fine = true;
    for (int k = 0; k < 3; k++) {
        fine = fine && fabsf(v->position[k]) < 1e9f;
    }
    return fine && fabsf(v->uv[0]) < 1e6f && fabsf(v->uv[1]) < 1e6f;
}

static enum pel_err take_mesh(struct import *in, const struct aiMesh *mesh,
                              const struct aiMatrix4x4 *to, int node,
                              struct pel_fault *fault)
{
    struct aiMatrix3x3 turn;
    unsigned index = mesh->mMaterialIndex;
    if (!(mesh->mPrimitiveTypes & aiPrimitiveType_TRIANGLE)) {
        return PEL_OK;
    }
    if (in->materials[index] < 0) {
        enum pel_err err =
            make_material(in, index, &in->materials[index], fault);
        if (err) {
            return err;
        }
    }
    /* Normals go by the inverse transposed; mirrors turn triangles around. */
    aiMatrix3FromMatrix4(&turn, to);
    float det = aiMatrix3Determinant(&turn);
    aiMatrix3Inverse(&turn);
    aiTransposeMatrix3(&turn);
    for (unsigned f = 0; f < mesh->mNumFaces; f++) {
        const struct aiFace *face = &mesh->mFaces[f];
        struct pel_model_vertex c[3];
        if (face->mNumIndices != 3) {
            continue;
        }
        for (int k = 0; k < 3; k++) {
            unsigned i = face->mIndices[det < 0 ? 2 - k : k];
            if (i >= mesh->mNumVertices) {
                return pel_fault_set(fault, PEL_ERR_INVALID,
                                     "a triangle has a corner that is not "
                                     "there");
            }
            c[k] = corner(mesh, i, to, &turn);
            if (!is_number(&c[k])) {
                return pel_fault_set(fault, PEL_ERR_INVALID,
                                     "a vertex is infinite or no number");
            }
        }
        pel_shape_triangle(in->shape, c, in->materials[index], node);
    }
    return in->shape->triangle_count > PEL_MODEL_MOST_TRIANGLES
               ? pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                               "more than %d triangles; simplify it",
                               PEL_MODEL_MOST_TRIANGLES)
               : PEL_OK;
}

/* Those without area. A whole file may have some, not most. */
static size_t flat_triangles(const struct pel_shape *s)
{
    size_t count = 0;
    for (size_t i = 0; i < s->triangle_count; i++) {
        const struct pel_model_vertex *c = &s->corners[3 * i];
        double u[3], v[3], u2 = 0, v2 = 0, uv = 0;
        for (int k = 0; k < 3; k++) {
            u[k] = (double)c[1].position[k] - (double)c[0].position[k];
            v[k] = (double)c[2].position[k] - (double)c[0].position[k];
            u2 += u[k] * u[k];
            v2 += v[k] * v[k];
            uv += u[k] * v[k];
        }
        count += u2 * v2 - uv * uv <= 1e-12 * u2 * v2; /* sine below 1e-6 */
    }
    return count;
}

/* NOLINTNEXTLINE(misc-no-recursion): MOST_DEPTH deep. */
static enum pel_err take_node(struct import *in, const struct aiNode *node,
                              const struct aiMatrix4x4 *parent, int depth,
                              struct pel_fault *fault)
{
    struct aiMatrix4x4 to = *parent;
    enum pel_err err = PEL_OK;
    if (depth > MOST_DEPTH) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "its nodes are more than %d deep", MOST_DEPTH);
    }
    aiMultiplyMatrix4(&to, &node->mTransformation);
    int own = (int)in->shape->node_count - 1;
    if (node->mNumMeshes > 0 && in->shape->node_count < PEL_MODEL_MOST_NODES) {
        own = pel_shape_node(in->shape, node->mName.data);
    }
    for (unsigned i = 0; i < node->mNumMeshes && !err; i++) {
        err = take_mesh(in, in->scene->mMeshes[node->mMeshes[i]], &to, own,
                        fault);
    }
    for (unsigned i = 0; i < node->mNumChildren && !err; i++) {
        err = take_node(in, node->mChildren[i], &to, depth + 1, fault);
    }
    return err;
}

/* --- into the model's frame
 * --------------------------------------------------------------- */

static void bound(const struct pel_shape *s, double low[3], double high[3])
{
    for (int k = 0; k < 3; k++) {
        low[k] = INFINITY;
        high[k] = -INFINITY;
    }
    for (size_t i = 0; i < 3 * s->triangle_count; i++) {
        for (int k = 0; k < 3; k++) {
            low[k] = fmin(low[k], (double)s->corners[i].position[k]);
            high[k] = fmax(high[k], (double)s->corners[i].position[k]);
        }
    }
}

static struct pel_vec3 axis_of(enum pel_axis axis)
{
    double v[3] = { 0 };
    v[axis / 2] = axis % 2 ? -1 : 1;
    return (struct pel_vec3){ v[0], v[1], v[2] };
}

/* The axes' names as they are given, or as they lie. */
static enum pel_err choose_axes(const struct pel_mesh_request *r,
                                const double low[3], const double high[3],
                                enum pel_axis *bow, enum pel_axis *up,
                                struct pel_fault *fault)
{
    const char *ending = strrchr(r->path, '.');
    bool stl = ending && strcasecmp(ending, ".stl") == 0;
    *up = r->up != PEL_AXIS_NONE ? r->up : stl ? PEL_AXIS_Z : PEL_AXIS_Y;
    int a = (*up / 2 + 1) % 3, b = (*up / 2 + 2) % 3;
    int longest = high[a] - low[a] >= high[b] - low[b] ? a : b;
    *bow = r->bow != PEL_AXIS_NONE ? r->bow : (enum pel_axis)(2 * longest);
    return *bow / 2 != *up / 2
               ? PEL_OK
               : pel_fault_set(fault, PEL_ERR_CONFLICT,
                               "its bow is along the axis that is up; give "
                               "both");
}

static void turn(float v[3], struct pel_vec3 x, struct pel_vec3 y,
                 struct pel_vec3 z)
{
    struct pel_vec3 p = { (double)v[0], (double)v[1], (double)v[2] };
    v[0] = (float)pel_vec3_dot(p, x);
    v[1] = (float)pel_vec3_dot(p, y);
    v[2] = (float)pel_vec3_dot(p, z);
}

#define LEAST_SIZE_M 0.1 /* of what is seen at sea */

/* Metres of one of its units: as is said, or metres, or, where it would be
 * larger than anything, millimetres. */
static double choose_scale(const struct pel_mesh_request *r,
                           const double low[3], const double high[3],
                           struct pel_mesh_notes *notes)
{
    double length = high[0] - low[0];
    double most = fmax(length, fmax(high[1] - low[1], high[2] - low[2]));
    if (r->scale > 0) {
        return r->scale;
    }
    if (r->length_m > 0 && length > 0) {
        return r->length_m / length;
    }
    if (most > PEL_MODEL_MOST_SIZE_M && most <= 1e3 * PEL_MODEL_MOST_SIZE_M) {
        pel_mesh_note(notes,
                      "taken as millimetres: %.4g m long; give its "
                      "length or scale in the .json beside it",
                      length / 1000);
        return 0.001;
    }
    if (most < LEAST_SIZE_M) {
        pel_mesh_note(notes,
                      "only %.2g m long; give its length or scale in the "
                      ".json beside it",
                      length);
    }
    return 1;
}

static enum pel_err place(const struct pel_mesh_request *r, struct pel_shape *s,
                          struct pel_mesh_notes *notes, struct pel_fault *fault)
{
    double low[3], high[3];
    enum pel_axis bow, up;
    bound(s, low, high);
    enum pel_err err = choose_axes(r, low, high, &bow, &up, fault);
    if (err) {
        return err;
    }
    struct pel_vec3 x = axis_of(bow), z = axis_of(up);
    struct pel_vec3 y = pel_vec3_cross(z, x);
    for (size_t i = 0; i < 3 * s->triangle_count; i++) {
        turn(s->corners[i].position, x, y, z);
        turn(s->corners[i].normal, x, y, z);
    }
    bound(s, low, high);
    double scale = choose_scale(r, low, high, notes);
    double bottom = low[2] * scale;
    double water = r->draught_m >= 0           ? bottom + r->draught_m
                   : low[2] < 0 && high[2] > 0 ? 0
                                               : bottom;
    const double shift[] = { -scale * (low[0] + high[0]) / 2,
                             -scale * (low[1] + high[1]) / 2, -water };
    for (size_t i = 0; i < 3 * s->triangle_count; i++) {
        for (int k = 0; k < 3; k++) {
            float *p = &s->corners[i].position[k];
            *p = (float)((double)*p * scale + shift[k]);
        }
    }
    double most = scale * fmax(high[0] - low[0],
                               fmax(high[1] - low[1], high[2] - low[2]));
    if (most > PEL_MODEL_MOST_SIZE_M) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "it is %.4g m large, at most %.0f m; give its "
                             "length or scale in the .json beside it",
                             most, PEL_MODEL_MOST_SIZE_M);
    }
    return PEL_OK;
}

/* --- reading
 * ----------------------------------------------------------------------------------
 */

/* What the library says of damage that it passes over. */
struct complaints {
    bool out_of_range; /* triangles with corners that are not there */
    struct pel_mesh_notes *notes;
};

/* "Warn,  T0: Some vertices were dropped." */
static void hear(const char *message, char *user)
{
    struct complaints *heard = (struct complaints *)user;
    const char *text = strstr(message, ": ");
    bool error = strncmp(message, "Error", 5) == 0;
    if (!text || (!error && strncmp(message, "Warn", 4) != 0)) {
        return;
    }
    heard->out_of_range |= strstr(text, "out-of-range indices") != NULL;
    int length = (int)strcspn(text + 2, "\n");
    char plain[100];
    snprintf(plain, sizeof plain, "%.*s", length, text + 2);
    if ((error || strstr(text, "dropped")) &&
        !strstr(heard->notes->text, plain)) {
        pel_mesh_note(heard->notes, "%s", plain);
    }
}

/* Drops empty meshes of a node and of the nodes below it. */
/* NOLINTNEXTLINE(misc-no-recursion): MOST_DEPTH deep. */
static void renumber(struct aiNode *node, const unsigned *number,
                     unsigned count, int depth)
{
    unsigned kept = 0;
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        unsigned from = node->mMeshes[i];
        unsigned to = from < count ? number[from] : UINT_MAX;
        if (to != UINT_MAX) {
            node->mMeshes[kept++] = to;
        }
    }
    node->mNumMeshes = kept;
    for (unsigned i = 0; i < node->mNumChildren && depth < MOST_DEPTH; i++) {
        renumber(node->mChildren[i], number, count, depth + 1);
    }
}

/* Without meshes that have nothing in them, as the empty solids of an STL: the
 * library's check would refuse all for one. */
static bool leave_out_empty(struct aiScene *scene)
{
    unsigned kept = 0, count = scene->mNumMeshes;
    unsigned *number = malloc((count + 1) * sizeof *number);
    if (!number) {
        return false;
    }
    for (unsigned i = 0; i < count; i++) {
        struct aiMesh *m = scene->mMeshes[i];
        bool empty = m->mNumVertices == 0 || m->mNumFaces == 0;
        number[i] = empty ? UINT_MAX : kept;
        scene->mMeshes[kept] = m;
        kept += !empty;
    }
    if (kept < count && kept > 0) {
        scene->mNumMeshes = kept;
        renumber(scene->mRootNode, number, count, 0);
    }
    free(number);
    return kept > 0 || count == 0;
}

static const struct aiScene *import_scene(const char *path,
                                          struct complaints *heard, bool *empty)
{
    const struct aiLogStream log = { hear, (char *)heard };
    aiAttachLogStream(&log);

    struct aiPropertyStore *store = aiCreatePropertyStore();
    aiSetImportPropertyInteger(store, AI_CONFIG_PP_SBP_REMOVE,
                               aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    aiSetImportPropertyInteger(store, AI_CONFIG_PP_FD_REMOVE, 1);
    const struct aiScene *scene =
        aiImportFileExWithProperties(path, 0, NULL, store);
    if (!scene || !scene->mRootNode) {
        return scene;
    }
    *empty = !leave_out_empty((struct aiScene *)scene);
    return *empty ? scene
                  : aiApplyPostProcessing(
                        scene, aiProcess_Triangulate | aiProcess_SortByPType |
                                   aiProcess_ValidateDataStructure |
                                   aiProcess_TransformUVCoords);
}

enum pel_err pel_mesh_read(const struct pel_mesh_request *request,
                           struct pel_shape *shape,
                           struct pel_mesh_notes *notes,
                           struct pel_fault *fault)
{
    const char *ending = strrchr(request->path, '.');
    struct import in = { .request = request, .shape = shape, .notes = notes };
    struct aiMatrix4x4 none;
    in.gltf =
        strcasecmp(ending, ".glb") == 0 || strcasecmp(ending, ".gltf") == 0;
    enum pel_err err = in.gltf ? pel_gltf_check(request->path, fault) : PEL_OK;
    if (err) {
        return err;
    }
    struct complaints heard = { .notes = notes };
    bool empty = false;
    in.scene = import_scene(request->path, &heard, &empty);
    if (!in.scene || !in.scene->mRootNode) {
        return pel_fault_set(fault, PEL_ERR_INVALID, "%.200s",
                             aiGetErrorString());
    }
    if (empty) {
        return pel_fault_set(fault, PEL_ERR_INVALID, "it has no triangles");
    }
    if (heard.out_of_range) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "triangles have corners that are not there");
    }
    unsigned count = in.scene->mNumMaterials;
    in.materials = malloc((count + 1) * sizeof *in.materials);
    if (!in.materials) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    memset(in.materials, 0xff, (count + 1) * sizeof *in.materials);
    pel_shape_node(shape, "all");
    aiIdentityMatrix4(&none);
    err = take_node(&in, in.scene->mRootNode, &none, 0, fault);
    if (!err && shape->triangle_count == 0) {
        err = pel_fault_set(fault, PEL_ERR_INVALID, "it has no triangles");
    }
    if (!err && flat_triangles(shape) > shape->triangle_count / 2) {
        err = pel_fault_set(fault, PEL_ERR_INVALID,
                            "%zu of its %zu triangles have no area: its "
                            "vertices are damaged",
                            flat_triangles(shape), shape->triangle_count);
    }
    if (in.scene->mNumAnimations > 0) {
        pel_mesh_note(notes, "it stands still: animations are not played");
    }
    return err ? err : place(request, shape, notes, fault);
}
