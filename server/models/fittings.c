/* What ships have in common above their decks. */
#include <stdio.h>

#include "models/kinds.h"

#define PROUD 0.08 /* m that windows stand out of their wall */
/* An eye of a wheelhouse looks out of it: walls have no inside. */
#define EYE_BEFORE 0.4

void pel_kind_eye(struct pel_pen *pen, const char *name, double x, double y,
                  double z)
{
    struct pel_shape *s = pen->shape;
    struct pel_model_eye *eye = &s->eyes[s->eye_count++];
    snprintf(eye->name, sizeof eye->name, "%s", name);
    eye->at = (struct pel_vec3){ x, y, z };
}

void pel_kind_light(struct pel_pen *pen, const char *name, uint32_t colour,
                    double miles, double from, double to, struct pel_vec3 at)
{
    struct pel_shape *s = pen->shape;
    struct pel_model_light *light = &s->lights[s->light_count++];
    *light = (struct pel_model_light){ .at = at,
                                       .range_m = (float)(1852 * miles),
                                       .from_rad = (float)(from * PEL_DEG),
                                       .to_rad = (float)(to * PEL_DEG) };
    snprintf(light->name, sizeof light->name, "%s", name);
    for (int k = 0; k < 3; k++) {
        light->colour[k] = (float)(colour >> (16 - 8 * k) & 255) / 255.0f;
    }
}

void pel_kind_navigation(struct pel_pen *pen, const struct pel_kind_size *size,
                         struct pel_vec3 masthead, struct pel_vec3 second,
                         struct pel_vec3 side, struct pel_vec3 stern)
{
    bool large = size->length >= 50, small = size->length < 12;
    double mast = large ? 6 : size->length >= 20 ? 5 : small ? 2 : 3;
    double low = large ? 3 : 2;
    struct pel_vec3 port = { side.x, fabs(side.y), side.z };
    struct pel_vec3 starboard = { side.x, -fabs(side.y), side.z };
    pel_kind_light(pen, "masthead", 0xffffff, mast, -112.5, 112.5, masthead);
    if (large) {
        pel_kind_light(pen, "masthead 2", 0xffffff, mast, -112.5, 112.5,
                       second);
    }
    pel_kind_light(pen, "port", 0xff0000, small ? 1 : low, -112.5, 0, port);
    pel_kind_light(pen, "starboard", 0x00ff40, small ? 1 : low, 0, 112.5,
                   starboard);
    pel_kind_light(pen, "stern", 0xffffff, low, 112.5, 247.5, stern);
}

void pel_kind_wheelhouse(struct pel_pen *pen, const char *eye, double x0,
                         double x1, double wide, double z0, double z1)
{
    pel_kind_eye(pen, eye, x1 + EYE_BEFORE, 0, z0 + 0.62 * (z1 - z0));
    double h = z1 - z0, lean = 0.25 * h;
    const struct pel_vec2 low[] = {
        { x0, z0 }, { x1, z0 }, { x1, z0 + 0.42 * h }, { x0, z0 + 0.42 * h }
    };
    /* Windows lean outward; the roof overhangs. */
    const struct pel_vec2 glass[] = { { x0 + 0.1 * h, z0 + 0.42 * h },
                                      { x1 - 0.02, z0 + 0.42 * h },
                                      { x1 + 0.5 * lean, z0 + 0.85 * h },
                                      { x0 + 0.1 * h, z0 + 0.85 * h } };
    const struct pel_vec2 roof[] = { { x0 - 0.1 * h, z0 + 0.85 * h },
                                     { x1 + lean, z0 + 0.85 * h },
                                     { x1 + lean, z1 },
                                     { x0 - 0.1 * h, z1 } };
    pel_solid_side(pen, low, 4, -wide / 2, wide / 2);
    pel_solid_side(pen, roof, 4, -wide / 2 - 0.1 * h, wide / 2 + 0.1 * h);
    int material = pen->material;
    pel_pen_paint(pen, PEL_GLASS, 0.1);
    pel_solid_side(pen, glass, 4, -wide / 2 + 0.05 * h, wide / 2 - 0.05 * h);
    pen->material = material;
}

void pel_kind_windows(struct pel_pen *pen, double x0, double x1, double wide,
                      double z0, double deck, int decks)
{
    int material = pen->material;
    pel_pen_paint(pen, PEL_GLASS, 0.15);
    for (int d = 0; d < decks; d++) {
        double low = z0 + (d + 0.45) * deck, high = low + 0.3 * deck;
        double pitch = 1.0 * deck;
        int count = (int)((x1 - x0 - 0.4 * deck) / pitch);
        for (int i = 0; i < count; i++) {
            double x = x0 + 0.5 * deck + i * pitch;
            pel_solid_boxes(pen, x, x + 0.3 * deck, wide / 2 - PROUD,
                            wide / 2 + PROUD, low, high);
        }
        count = (int)((wide - 0.6 * deck) / (1.3 * deck));
        for (int i = 0; i < count; i++) {
            double y = (i - 0.5 * (count - 1)) * 1.3 * deck;
            pel_solid_box(pen, x1 - PROUD, x1 + PROUD, y - 0.16 * deck,
                          y + 0.16 * deck, low, high);
        }
    }
    pen->material = material;
}

void pel_kind_funnel(struct pel_pen *pen, double x, double y, double long_m,
                     double wide, double z0, double z1, uint32_t colour)
{
    struct pel_vec2 outline[12], inside[12];
    double h = z1 - z0;
    const struct {
        double low, high;
        uint32_t colour;
    } bands[] = { { 0, 0.5, colour },
                  { 0.5, 0.72, PEL_SHIP_WHITE },
                  { 0.72, 0.88, colour },
                  { 0.88, 1, PEL_BLACK } };
    for (int i = 0; i < 12; i++) {
        double a = 2 * PEL_PI * i / 12;
        outline[i] =
            (struct pel_vec2){ x + long_m / 2 * cos(a), y + wide / 2 * sin(a) };
        inside[i] =
            (struct pel_vec2){ x + long_m / 4 * cos(a), y + wide / 4 * sin(a) };
    }
    for (int i = 0; i < 4; i++) {
        pel_pen_paint(pen, bands[i].colour, 0.5);
        pel_solid_tower(pen, outline, 12, z0 + bands[i].low * h,
                        z0 + bands[i].high * h, 1, x, y);
    }
    pel_solid_tower(pen, inside, 12, z1, z1 + 0.12 * h, 1, x, y);
}

void pel_kind_mast(struct pel_pen *pen, double x, double z0, double z1,
                   double yard)
{
    double h = z1 - z0, r = fmax(0.03, 0.022 * h);
    pel_solid_pole(pen, (struct pel_vec3){ x, 0, z0 },
                   (struct pel_vec3){ x, 0, z1 }, 1.6 * r, r, 8);
    if (yard > 0) {
        pel_solid_pole(pen, (struct pel_vec3){ x, -yard / 2, z0 + 0.6 * h },
                       (struct pel_vec3){ x, yard / 2, z0 + 0.6 * h }, r, r, 6);
        pel_solid_block(pen, x + 1.5 * r, x + 5 * r, 0.5 * yard, z0 + 0.42 * h,
                        z0 + 0.42 * h + 3 * r);
        pel_solid_block(pen, x, x + 4 * r, 4 * r, z0 + 0.36 * h, z0 + 0.42 * h);
    }
}
