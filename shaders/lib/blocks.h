/* Uniform blocks, one text for C and GLSL: vec4 only, so that std140 and C lay
 * them out alike. */
#ifdef __STDC__
#pragma once
struct pel_vec4 {
    float x, y, z, w;
};
#define vec4 struct pel_vec4
#define PEL_STRUCT struct
#define PEL_BLOCK(index, name) struct pel_block_##name
#else
#define PEL_BLOCK(index, name) layout(std140, binding = index) uniform name##_block
#define PEL_STRUCT
#endif

#define PEL_WAVE_LIMIT 256

/* Slope variance left to the BRDF along and across the wind, by the footprint
 * of a pixel: PEL_VARIANCE_STEPS entries an octave from 2^PEL_VARIANCE_FIRST m. */
#define PEL_VARIANCE_FIRST -10.0
#define PEL_VARIANCE_STEPS 8.0
#define PEL_VARIANCE_COUNT 192

/* The same by the footprint's azimuth from the wind (π is a turn), by how many
 * times it is longer along that than across, and by its length along. */
#define PEL_AZIMUTH_COUNT 16
#define PEL_ASPECT_STEPS 2.0 /* an octave */
#define PEL_ASPECT_COUNT 9   /* 1 to 16 */
#define PEL_LENGTH_STEPS 4.0 /* an octave from 2^PEL_VARIANCE_FIRST m */
#define PEL_LENGTH_COUNT 96

/* Levels of detail by which positions are sampled sharper than slopes. */
#define PEL_SHIFT_SHARPER 1.5

/* Width of the taps along a footprint, of its length: their variance with the
 * ends' is that of the level of detail they stand for. */
#define PEL_TAP_SPAN 1.2

/* One for a frame. Spectral values are at 680, 550, 440 nm. */
PEL_BLOCK(0, frame) {
    vec4 sun;      /* xyz towards the Sun; w angular radius, rad */
    vec4 solar;    /* rgb irradiance above the air; w solid angle, sr */
    vec4 wind;     /* xy unit, blows to; zw total slope variance along, cross */
    vec4 rayleigh; /* rgb scattering at sea level, 1/m; w scale height, m */
    vec4 mie;      /* x extinction, y scattering, 1/m; z scale height; w g */
    vec4 ozone;    /* rgb peak absorption, 1/m; w height of the peak, m */
    vec4 planet;   /* x ground, y top radius, m; z ozone half-width, m; w R0 */
    vec4 water;    /* levels of depth (lib/water.glsl): x their number, y log2 of the
                      first, m, z levels an octave; w 1 leaves out the air */
    vec4 disc;     /* x variance of slopes that mirror some of the Sun's disc */
    vec4 red;      /* rows of the matrix to Rec. 709 cd/m² */
    vec4 green;
    vec4 blue;
};

/* One for an eye, a camera position of this frame. */
PEL_BLOCK(1, eye) {
    vec4 eye; /* x height above the sea, m; y dip of the horizon, rad; z angle
                 between the mesh's columns, rad; w columns around */
    vec4 lut; /* x height the sky tables were made for, m; y 1 under water */
};

/* One for a view. The pixel lattice is X right, Y down, in pixels from the
 * axis: a ray is right·X·px − up·Y·py − back. */
PEL_BLOCK(2, view) {
    vec4 right; /* camera axes in the world; w of right: N_min */
    vec4 up;    /* w: 1 / (N_max − N_min) */
    vec4 back;  /* w: levels of detail that slopes are sampled coarser */
    vec4 pixel; /* px, py; lattice place of the picture's top left corner */
    vec4 size;  /* width, height, px; z fixed EV100; w 1 when automatic */
    vec4 sensor; /* x 0 none, 1 a sensor's grey, 2 no picture; grey · y + z; w
                    noise */
    vec4 sensor_seed; /* xy 0..65535; z share of lines that drop out */
};

/* A wave as the shaders sum it; k̂ unit, c chop, h amplitude. */
struct pel_shader_wave {
    vec4 phase; /* k / 2π xy, 1/m; phase at the eye's nadir now, turns; λ, m */
    vec4 fold;  /* c h k (k̂x², k̂x k̂y, k̂y²); 1/λ, 1/m */
    vec4 slope; /* h k xy */
    vec4 shift; /* c h k̂ xy; h */
};

/* One for an eye. Longest first; padded with waves of no length. */
PEL_BLOCK(3, waves) {
    PEL_STRUCT pel_shader_wave waves[PEL_WAVE_LIMIT];
};

/* As in ocean/shear.h. */
#define PEL_SHEAR_RATIO 1.29

/* One for an eye, instead of the waves, where the sea is made of FFT cascades
 * (ocean/cascade.h). */
struct pel_shader_cascade {
    vec4 place;  /* xy turn; z 1 / length, 1/m; w texel, m */
    vec4 offset; /* xy place of the eye's nadir, in tiles; zw its turns of the
                    two shears (ocean/shear.h) */
    vec4 shear;  /* xy f of the first, 1/m; z shear / |f|², m² */
};
#define PEL_LONGEST_OF_CASCADE 0.1548 /* wave of all but the first, in its lengths */
PEL_BLOCK(5, cascades) {
    PEL_STRUCT pel_shader_cascade cascades[4];
};

/* Gauss quadrature over the facets an eye sees (optics/facets.h), by
 * q = μ / (1 + μ) in PEL_FACET_STEPS equal steps from 0 to 1; the shaders read
 * it as texels. */
#define PEL_FACET_STEPS 64
#ifdef __STDC__
struct pel_shader_facets {
    vec4 node;   /* slopes towards the eye, standard deviations */
    vec4 weight; /* sum 1 */
};
struct pel_block_facets {
    struct pel_shader_facets facets[PEL_FACET_STEPS + 1];
};
#endif

/* Written by the light pass. */
PEL_BLOCK(4, light) {
    vec4 exposure;  /* x automatic EV100 */
    vec4 sun_light; /* rgb irradiance of the Sun normal to its beam, sea level */
    vec4 sky_light; /* rgb horizontal irradiance of the sky */
    vec4 sea_light; /* rgb the water's radiance, seen at 37° across the Sun */
};

/* Levels of seabed_tops, the highest nodes of squares: level k has one for each
 * square of 2^(k+1) spaces between nodes, borders and all. */
#define PEL_SEABED_TOP_LEVELS 11

/* Depths in steps of half an octave from 2^PEL_FOCUS_FIRST m. */
#define PEL_FOCUS_FIRST -2.0
#define PEL_FOCUS_COUNT 20

/* One for an eye over a height field (render/seabedmap.h). */
PEL_BLOCK(9, seabed) {
    vec4 bed_place;  /* xy the eye's nadir in nodes; z nodes a metre; w metres between nodes */
    vec4 bed_size;   /* columns, rows; z highest, above the sea's zero, m; w the file's zero
                        above it, m */
    vec4 bed_beyond; /* x height beyond the field, m; y up to where waves wet the land, m;
                        z levels of seabed_tops; w 1 with caustics */
    vec4 bed_wet;    /* rgb albedo of wet land */
    vec4 bed_dry;    /* rgb of dry land and under water */
    vec4 bed_level[PEL_SEABED_TOP_LEVELS]; /* of seabed_tops: x place of the first, y columns,
                                              z rows */
    vec4 bed_focus[PEL_FOCUS_COUNT]; /* by depth: x log2 of the footprint, m, whose waves focus
                                        light without crossing rays */
    vec4 bed_extinction; /* rgb of the water, 1/m; w radiance above the water that the Sun's
                            beam of unit irradiance leaves on a white level bottom, 1/sr */
    vec4 bed_fall;       /* rgb of scattered light by length, octaves a metre; w the number
                            of cascades */
    vec4 bed_absorption; /* rgb, 1/m; 0 where only two orders are drawn */
    vec4 bed_turned;     /* rgb scattering (1 − asymmetry), 1/m, or 0; w 1 where slopes are
                            steeper than the Sun's beam in the water */
};

/* Light inside the water (render/waterlight.h). Sizes of its maps: nodes of
 * beams and of lines of sight, modes in azimuth, planes, zenith angles in each
 * hemisphere and azimuths in half a circle, texels a side, rows of sky. */
#define PEL_WATER_NODES 12
#define PEL_WATER_MODES 10
#define PEL_WATER_PLANES 10
#define PEL_WATER_ZENITHS 48
#define PEL_WATER_AZIMUTHS 48
#define PEL_WATER_MAP_SIZE 64
#define PEL_WATER_SKY_ROWS 32
PEL_BLOCK(10, medium) {
    vec4 full_extinction;   /* rgb, 1/m; w 1: every order is drawn */
    vec4 single_extinction; /* rgb, of single scattering */
    vec4 scattering;        /* rgb, 1/m */
    vec4 ground;            /* rgb albedo of the bottom */
    vec4 asymmetry;         /* rgb */
    vec4 depth[24];         /* x m, of each level */
};
PEL_BLOCK(11, sunbeam) {
    vec4 sunbeam;      /* in the water: x sine, y cosine of its zenith angle; z
                          irradiance normal to it for 1 above the surface */
    vec4 at_nodes[3];  /* weights of the nodes that make its sine */
};
/* A row of the sky or of the map: its place among the nodes. */
struct pel_shader_row {
    vec4 at; /* sky: x elevation, rad, y what a texel's radiance adds to the beam
                below; map: x sine, y cosine of the zenith angle in the water */
    vec4 at_nodes[3];
};

#ifdef __STDC__
#undef vec4
#undef PEL_STRUCT
#endif
