/* Constants, bindings and uniform blocks, one text for C and GLSL: a number
 * that both know stands here and nowhere else. Blocks hold vec4 only, so that
 * std140 and C lay them out alike. */
#ifdef __STDC__
#pragma once
struct pel_vec4 {
    float x, y, z, w;
};
#define vec4 struct pel_vec4
struct pel_uvec4 {
    unsigned x, y, z, w;
};
#define uvec4 struct pel_uvec4
#define PEL_STRUCT struct
#define PEL_BLOCK(index, name) struct pel_block_##name
#else
#define PEL_BLOCK(index, name)                                                 \
    layout(std140, binding = index) uniform name##_block
#define PEL_STRUCT
#endif

/* --- bindings ------------------------------------------------------------- */

/* Uniform blocks. OpenGL promises fourteen a stage, and drivers count those
 * that are declared: blocks of some programs only are declared in those. */
#define PEL_BLOCK_FRAME 0
#define PEL_BLOCK_EYE 1
#define PEL_BLOCK_VIEW 2
#define PEL_BLOCK_WASH 3
#define PEL_BLOCK_LIGHT 4
#define PEL_BLOCK_CASCADES 5
#define PEL_BLOCK_AREAS 8
#define PEL_BLOCK_WAKES 6
#define PEL_BLOCK_SHORE 7
#define PEL_BLOCK_SEABED 9
#define PEL_BLOCK_MEDIUM 10
#define PEL_BLOCK_UNDER 10 /* of an eye under water, in the former's place */
#define PEL_BLOCK_BEAM 11
#define PEL_BLOCK_EXPOSURE 12
#define PEL_BLOCK_SIGHTS 13
#define PEL_BLOCK_SURROUNDINGS 14
#define PEL_BLOCK_SPACE 15

/* Texture units of shading. */
#define PEL_UNIT_TRANSMITTANCE 0
#define PEL_UNIT_REFLECTION 1
#define PEL_UNIT_WAKES 2 /* ship waves */
#define PEL_UNIT_EYE_TABLE 3
#define PEL_UNIT_EYE_HAZE 4
#define PEL_UNIT_TRIANGLES 5
#define PEL_UNIT_DISPLACEMENT 6 /* 6 to 8: the cascades' fields */
#define PEL_UNIT_SLOPES 7
#define PEL_UNIT_FOLD 8
#define PEL_UNIT_WATER 9
#define PEL_UNIT_FACETS 10
#define PEL_UNIT_SECOND 11
#define PEL_UNIT_SEABED_HEIGHTS 12
#define PEL_UNIT_WAVES 13
#define PEL_UNIT_VARIANCE 14
#define PEL_UNIT_VERTICES 15
#define PEL_UNIT_OBJECT_VERTICES 16 /* 16 to 24: objects */
#define PEL_UNIT_OBJECT_TRIANGLES 17
#define PEL_UNIT_OBJECT_MATERIALS 18
#define PEL_UNIT_OBJECT_PLACES 19
#define PEL_UNIT_OBJECT_HULLS 20
#define PEL_UNIT_OBJECTS 21
#define PEL_UNIT_SURROUNDINGS 22
#define PEL_UNIT_OBJECT_SHADOWS 23
#define PEL_UNIT_MIRRORS 24
#define PEL_UNIT_BREAKING 25 /* 25 to 27: whitecaps */
#define PEL_UNIT_FOAM 26
#define PEL_UNIT_FOAM_GRAIN 27
#define PEL_UNIT_MIRROR_DEPTHS 28  /* objects, too */
#define PEL_UNIT_OBJECT_SAMPLES 29 /* 29 to 31: objects' silhouettes */
#define PEL_UNIT_OBJECT_DEPTHS 30
#define PEL_UNIT_OBJECT_COVER 31
/* Of one synthesiser, in a place of the other's. */
#define PEL_UNIT_SHORE_OF_CASCADES 13
#define PEL_UNIT_SHORE_OF_WAVES 6
/* Of a sensor's picture alone: planes of layers from 39 on (sense.frag). */
#define PEL_UNIT_SENSE_ROUGH 37
#define PEL_UNIT_ACUITY_ROWS 37 /* of pictures that no sensor makes */
#define PEL_UNIT_SENSE_HEAT 38
#define PEL_UNIT_SENSE_PLANES 39
#define PEL_SENSE_PLANES 6
/* A program uses 32 at most; which of these do not meet. */
#define PEL_UNIT_CLOUDS 32
#define PEL_UNIT_CLOUDSCAPE 33
#define PEL_UNIT_LAMPS 36      /* as they are drawn */
#define PEL_UNIT_LAMP_LIGHT 36 /* afterwards */
#define PEL_UNIT_LAMP_GLOWS 46
#define PEL_UNIT_CLOUD_SHADE 45
/* Of the sea from high up (lib/space.glsl). */
#define PEL_UNIT_SPACE_AIR 47
#define PEL_UNIT_SPACE_THROUGH 48
#define PEL_UNIT_SPACE_SKIES 49
#define PEL_UNIT_SPACE_WATERS 50
#define PEL_UNIT_SPACE_SECONDS 51
#define PEL_UNIT_SPACE_LAND 52
#define PEL_UNIT_SPACE_GROUND 53
#define PEL_UNIT_SPACE_WINDS 54
#define PEL_UNIT_SPACE_ROUGH 55
/* Of passes that do not shade, in places of the above. */
#define PEL_UNIT_RADIANCE 0     /* tone */
#define PEL_UNIT_COLORS 0       /* planes of luma and chroma */
#define PEL_UNIT_AIRLIGHT 1     /* tables of the sky */
#define PEL_UNIT_SKY_TABLE 2    /* light, water, reflection map */
#define PEL_UNIT_WATER_PHASE 12 /* 12 to 14: maps of the water */
#define PEL_UNIT_WATER_RADIANCE 13
#define PEL_UNIT_WATER_ATTENUATION 14
#define PEL_UNIT_NIGHT 34    /* 32 and up: what few pictures have */
#define PEL_UNIT_PANORAMA 34 /* of pictures without the night's */
#define PEL_UNIT_UNDER 35    /* of an eye under water, 35, 40 to 44, 56 to 58 */
#define PEL_UNIT_SHAFTS 40
#define PEL_UNIT_UNDER_FOUND 41
#define PEL_UNIT_UNDER_ABOVE 42
#define PEL_UNIT_UNDER_NORMAL 43
#define PEL_UNIT_UNDER_FOAM 44
#define PEL_UNIT_UNDER_BACK 56
#define PEL_UNIT_UNDER_LAMPS 57
#define PEL_UNIT_UNDER_LAMPS_ON 58
#define PEL_UNIT_AMPLITUDES 0 /* 0, 1: transforms of the cascades */
#define PEL_UNIT_MODES 1
#define PEL_UNIT_MIPS 0 /* after them */

/* Storage buffers of the mesh and of shading. */
#define PEL_STORE_VERTICES 0
#define PEL_STORE_RINGS 1
#define PEL_STORE_LAMPS 0 /* 0, 1: after the mesh */
#define PEL_STORE_SPOTS 1
#define PEL_STORE_WASH 3
#define PEL_STORE_KEYS 4
#define PEL_STORE_SEABED_TOPS 6
#define PEL_STORE_EDGES 5
#define PEL_STORE_SUSPECTS 7
#define PEL_STORE_MIXED 7 /* after them, in the same buffer */
/* Of other passes, in places of the above. */
#define PEL_STORE_LIGHT 2       /* block `light`, where it is written */
#define PEL_STORE_EXPOSURE 2    /* block `exposure`, the same */
#define PEL_STORE_WATER_TURNS 0 /* 0, 1, 5 to 7: maps of the water */
#define PEL_STORE_WATER_KERNEL 1
#define PEL_STORE_WATER_DIRECTIONS 5
#define PEL_STORE_WATER_COEFFICIENTS 5
#define PEL_STORE_WATER_NODES 6
#define PEL_STORE_WATER_ROWS 6
#define PEL_STORE_WATER_PLANES 7
#define PEL_STORE_UNDER_NEXT 7 /* a second kernel */
#define PEL_STORE_LINES 0      /* 0, 1: transforms of the cascades */
#define PEL_STORE_MODES 1
#define PEL_STORE_PROBE 5 /* 5, 6: probes */
#define PEL_STORE_PROBE_ANSWERS 6
#define PEL_STORE_FILTERED 0 /* 0, 1: filtered.comp */
#define PEL_STORE_FILTERED_ANSWERS 1
#define PEL_STORE_MOTES 2         /* particles in the water */
#define PEL_STORE_STARS 2        /* of a view, as it is shaded */
#define PEL_STORE_RADIANCE 6     /* of views that are drawn together */
#define PEL_STORE_PICTURES 8     /* 8 to 15: their readback buffers */
#define PEL_STORE_WAVES 16       /* of hardware; stays bound */
#define PEL_STORE_NET 17         /* the mesh, as it is shaded there */
#define PEL_STORE_COLORS 0       /* of them, before their planes are made */
#define PEL_STORE_PLANES 0       /* 0, 1: jpeg.comp */
#define PEL_STORE_JPEG 1
#define PEL_STORE_SURROUNDINGS 2 /* the block, where it is written */

/* Images of shading in compute: OpenGL promises eight. What more layers than
 * its slots are drawn by further passes. */
#define PEL_IMAGE_COLOR 0
#define PEL_IMAGE_RADIANCE 1
#define PEL_IMAGE_SLOTS 2
#define PEL_COMPUTE_SLOTS 6
/* Slots of shading in fragments: of eight attachments the first is the
 * radiance. */
#define PEL_FRAGMENT_SLOTS 7

/* Uniforms of shading: masks of the objects mirrored in the sea of a tile and
 * that shade it, the layers
 * of a pass as bits, and by slot. */
#define PEL_UNIFORM_NEAR 7
#define PEL_UNIFORM_LAYERS 8
#define PEL_UNIFORM_SLOTS 9
/* Of the mesh, for the outlines. */
#define PEL_UNIFORM_BLOCK_COUNT 19
#define PEL_UNIFORM_BLOCKS 20
#define PEL_UNIFORM_BASES 30
/* Texels of the only object near a tile. */
#define PEL_UNIFORM_PLACE 64

/* The radiance's fourth component: what a pixel shows, times the part of it
 * that shows no object. */
#define PEL_SHOWS_SEA 1.0 /* or the sky */
#define PEL_SHOWS_LAND -1.0

/* Images that passes before shading write. */
#define PEL_IMAGE_DISPLACEMENT 0
#define PEL_IMAGE_SLOPES 1
#define PEL_IMAGE_FOLD 2
#define PEL_IMAGE_BREAKING 0
#define PEL_IMAGE_MIPS 0
#define PEL_MIPS 4 /* levels that a dispatch of fft_mips.comp makes */
#define PEL_IMAGE_WATER_PHASE 0
#define PEL_IMAGE_WATER_RADIANCE 0
#define PEL_IMAGE_WATER_ATTENUATION 1
#define PEL_IMAGE_WATER_MAP 0
#define PEL_IMAGE_UNDER 0
#define PEL_IMAGE_SHAFTS 0
#define PEL_IMAGE_SURROUNDINGS 0
#define PEL_IMAGE_COVER 0
#define PEL_IMAGE_MIRRORS 0
#define PEL_IMAGE_MIRROR_DEPTHS 1

/* --- what C and the shaders agree on -------------------------------------- */

/* Invocations of a group along a line, and along a side of a square. */
#define PEL_GROUP_LINE 64
#define PEL_GROUP_WATER 32
#define PEL_GROUP_SIDE 8
/* Of a group that writes its colours to the host: whole lines of its caches
 * (docs/benchmarks.md). */
#define PEL_GROUP_WIDE 32
#define PEL_GROUP_LOW 2
/* Of a picture from the device (render/ycbcr.h): pixels, full range in three
 * planes, studio range in two. */
#define PEL_YCBCR_FORM_NONE 0
#define PEL_YCBCR_FORM_JPEG 1
#define PEL_YCBCR_FORM_VIDEO 2
/* A JPEG's scan as a group of jpeg.comp codes it: so many units of 16x16
 * pixels, each six blocks, whose bits come behind their number. They take so
 * many words at most, 1408 bits a block: of 8-bit samples no more than 16
 * coefficients of a block are 256 or more, whose codes have 25 or 26 bits; the
 * others take 18 for each place in the scan, and the mean 22, 1284 together.
 * From group to group whole lines of the host's caches. */
#define PEL_JPEG_UNITS 10
#define PEL_JPEG_BLOCKS 6
#define PEL_JPEG_MOST_WORDS 2640
#define PEL_JPEG_GROUP_WORDS 2688
/* Better ones have another transform. */
#define PEL_JPEG_BEST 95

/* Rings of the mesh that a crest hides at least where its outline is looked
 * for. With 1, four in five of the pixels that are looked at have none, which
 * costs a fifth of a frame on two cores instead of a fifteenth; the error that
 * edges_test finds is the same to 5 % up to 5, and rises from there. */
#define PEL_OUTLINE_HIDDEN 5
/* Pixels below each other that outline_find.comp looks at together. */
#define PEL_OUTLINE_ROWS 8
/* Kinds of blocks of the mesh that it tells apart. */
#define PEL_OUTLINE_BLOCKS 3

/* Refractive index of the water for what becomes of light inside it, as in the
 * 2010 paper; what the surface reflects has `refraction` of the frame. */
#define PEL_WATER_INDEX 1.34

/* Light scattered more than once (optics/airlight.h): sizes of its table;
 * heights by shares of the aerosols', the molecules' and the whole height; a
 * light's elevation e [rad] as asinh((e + MIDDLE) / WIDTH) from FIRST to LAST
 * (-20° to 90°), finest in twilight. */
#define PEL_AIR_SUNS 48
#define PEL_AIR_HEIGHTS 22
#define PEL_AIR_ZENITHS 28
#define PEL_AIR_AZIMUTHS 16
#define PEL_AIR_SHARE_MIE 0.3
#define PEL_AIR_SHARE_RAYLEIGH 0.45
#define PEL_AIR_SUN_MIDDLE 0.05
#define PEL_AIR_SUN_WIDTH 0.08
#define PEL_AIR_SUN_FIRST -2.029212
#define PEL_AIR_SUN_LAST 3.702403

/* The mean reflectance's fit, B eq. 26: R + (1 - R) (1 - cos)^(5 e^(FALL s)) /
 * (1 + ROUGH s^1.5). */
#define PEL_MEAN_FRESNEL_FALL -2.69
#define PEL_MEAN_FRESNEL_ROUGH 22.7

/* Its integral, eq. 24: midpoints along each axis of slopes, up to standard
 * deviations. */
#define PEL_MEAN_FRESNEL_STEPS 64
#define PEL_MEAN_FRESNEL_REACH 6.0

/* Waves that hide waves, beyond Smith's masking, which takes heights and slopes
 * as independent (docs/physics/light.md; fitted to rays over Gaussian seas).
 * With s the standard deviation of slopes and μ the cotangent of the view's
 * zenith angle over s, facets that are seen are steeper towards the eye by
 * s STEEPER / (1 + KNEE μ²) and less scattered (the inverse of their variance
 * is greater by NARROWER / (1 + μ²/4) of it), and of what they mirror at an
 * elevation of tangent η s one part escapes and ODDS Λ(η) / (1 + VIEW μ)² parts
 * meet another wave. */
#define PEL_SEEN_STEEPER 0.21
#define PEL_SEEN_KNEE 1.78
#define PEL_SEEN_NARROWER 0.05
#define PEL_ESCAPE_ODDS 7.5
#define PEL_ESCAPE_VIEW 0.93

/* Footprints that are seen as cells of the mesh: waves between the two are
 * shaded, and hide nothing. */
#define PEL_CELL_FOOTPRINT 8.0

/* What a reflected ray that does not escape sees: a map by its azimuth and by
 * its tangent over s, from FIRST at radius INNER to FIRST + SPAN at the edge.
 */
#define PEL_SECOND_SIZE 64
#define PEL_SECOND_INNER 0.4
#define PEL_SECOND_FIRST -2.5
#define PEL_SECOND_SPAN 4.0

/* Sparkle (lib/glints.glsl): the share of the slope variance left to the BRDF
 * that is drawn for each pixel, and for how long: the period, s, of the
 * shortest waves, m, at least. */
#define PEL_GLINT_SHARE 0.06
#define PEL_GLINT_SHORTEST 0.02
#define PEL_GLINT_LONGEST 10.0 /* m: footprints from there on lose it */
#define PEL_GLINT_LIFE 0.113

/* Length of a pixel on the sea, for the filter of its waves: its width times
 * the slant to this power; 1 is its whole length along the line of sight, as in
 * the 2010 paper. */
#ifdef PEL_PAPER
#define PEL_FOOTPRINT_ALONG 1.0
#else
#define PEL_FOOTPRINT_ALONG 0.7
#endif

/* Tables of the atmosphere, texels; half width of the reflection map, whose
 * horizon is at 1. */
#define PEL_TRANSMITTANCE_WIDTH 256
#define PEL_TRANSMITTANCE_HEIGHT 64
#define PEL_REFLECTION_HALF_WIDTH 1.4

/* Viewport beyond each edge of a picture that is rasterised, px. */
#define PEL_RASTER_MARGIN 128

#define PEL_MESH_MAX_BLOCKS 10

/* What shade.comp writes, and whether it sets the keys back to 0. */
#define PEL_WANTS_RADIANCE 1
#define PEL_WANTS_COLOR 2
#define PEL_LAST_PASS 4

/* Kinds of sensor (scene/snapshot.h). */
#define PEL_SHADER_SENSOR_ON 1
#define PEL_SHADER_SENSOR_OFF 2
/* Emissivity of the sea (optics/thermal.h) by the cosine, from 0 to 1 by equal
 * steps of its root, and by the slopes' deviation along an axis from 0 to MOST;
 * fourth roots of radiance by temperature from LEAST to MOST, K, and back. */
#define PEL_SENSE_COSINES 64
#define PEL_SENSE_DEVIATIONS 24
#define PEL_SENSE_DEVIATION_MOST 0.46
#define PEL_SENSE_HEATS 512
#define PEL_SENSE_LEAST_K 150.0
#define PEL_SENSE_MOST_K 500.0
/* Hot places of ships; uniforms of the program. */
#define PEL_SENSE_SPOTS 8
#define PEL_SENSE_UNIFORMS 4
#define PEL_SENSE_ALL (PEL_SENSE_UNIFORMS + 2 * PEL_SENSE_SPOTS)

/* The tone curve (docs/physics/eye.md): linear light that a screen shows of
 * exposed light x, f² (1 + FLARE) / (f + FLARE) with f = xᵖ / (STRETCH xᵖ +
 * HALF), p = POWER, so that MIDDLE becomes SHOWN and WHITE 1 (pel_tone_curve).
 * Colours keep LEAST of their saturation at any brightness, all of it far below
 * PALE. RED, GREEN and BLUE are what white balance makes of grey. */
#define PEL_TONE_FILMIC 0
#define PEL_TONE_LINEAR 1
#define PEL_TONE_MIDDLE 0.18
#define PEL_TONE_SHOWN 0.21
#define PEL_TONE_WHITE 256.0
#define PEL_TONE_POWER 0.83
#define PEL_TONE_FLARE 0.04
#define PEL_TONE_STRETCH 0.99217
#define PEL_TONE_HALF 0.78129
#define PEL_TONE_PALE 16.0
#define PEL_TONE_LEAST 0.25
#define PEL_TONE_LEAST_OF_LAMPS 0.8 /* in pictures with lamps */
#define PEL_TONE_RED 0.956
#define PEL_TONE_GREEN 1.008
#define PEL_TONE_BLUE 1.047

/* Light at EV 0 that is MIDDLE, cd/m²: a meter's K = 12.5 at ISO 100. */
#define PEL_METER_MIDDLE 0.125
/* Windows that one meter looks through; samples in each. */
#define PEL_METER_SIGHTS 12
#define PEL_METER_COLUMNS 32
#define PEL_METER_ROWS 24
/* 1 - cos of the angles from a light within which a sample counts for nothing,
 * 1.5 deg, and from which on for all, 3 deg. */
#define PEL_METER_BLIND_FROM 3.427e-4
#define PEL_METER_BLIND_TO 1.3705e-3
/* What is made of them (pel_meter_ev). */
#define PEL_METER_KEY 0.25
#define PEL_METER_KEY_POWER 1.1
/* The light on the sea counts for so much of the adaptation, from three stops
 * above DULL lx on, none below; MATT: the luminance that stands for 1 lx. */
#define PEL_METER_INCIDENT 0.3
#define PEL_METER_DULL 5e3
#define PEL_METER_MATT 0.035
#define PEL_METER_HIGH 2.5
#define PEL_METER_LEAST -8.0
#define PEL_METER_MOST 14.45 /* in SUNLIGHT lx */
#define PEL_METER_SUNLIGHT 1e5
#define PEL_METER_SLOPE 0.0625

/* The eye's vision (server/optics/vision.h): CIE 191:2010's offset, slope and
 * V' where both luminances are one, 683/1699; its steps; the rods' colour, of
 * luminance 1. */
#define PEL_VISION_CAMERA 0
#define PEL_VISION_EYE 1
#define PEL_VISION_EYE_FIXED 2 /* of the meter alone: by a fixed EV */
#define PEL_EYE_OFFSET 0.767
#define PEL_EYE_SLOPE 0.3334
#define PEL_EYE_RODS 0.402001
#define PEL_EYE_STEPS 6
#define PEL_EYE_RED 1.0409
#define PEL_EYE_GREEN 0.9616
#define PEL_EYE_BLUE 1.2590
#define PEL_EYE_FALL 0.3
#define PEL_EYE_LEAST -12.0

/* The finest grating that an eye adapted to L cd/m² tells from grey, cycles a
 * degree: SPAN atan(STEEP lg L + OFF) + MIDDLE; L no less than 2^LEAST. HALF:
 * deviation of a Gaussian that halves such a grating's contrast, rad times
 * cycles a degree. DAY: of 10 cd/m², which those who look at the picture have
 * themselves. What is SHARP times brighter than what the eye is adapted to is
 * not spread. Widest deviation, pixels; most pixels that it needs beyond the
 * picture's edges. */
#define PEL_ACUITY_MIDDLE 25.72
#define PEL_ACUITY_SPAN 17.25
#define PEL_ACUITY_STEEP 1.4
#define PEL_ACUITY_OFF 0.35
#define PEL_ACUITY_LEAST -13.2877
#define PEL_ACUITY_HALF 3.27058e-3
#define PEL_ACUITY_DAY 43.861
#define PEL_ACUITY_SHARP 10.0
#define PEL_ACUITY_WIDEST 32.0
#define PEL_ACUITY_BORDER 128

/* Sources of glare. Lamps are to be more of them (meter.comp). */
#define PEL_GLARES PEL_LIGHTS
/* Where it has half the brightness of its centre, rad. */
#define PEL_GLARE_CORE 0.0175

/* Of the light that scatters a steradian has in the middle: 1 over
 * π c² ln(1 + 4 / c²), c the core. */
#define PEL_GLARE_NORM 109.7

/* Lamps: pixels that their light reaches at most, radius of their spread at
 * least; what of exposed light is seen as a halo; what of its distance the sea
 * may stand before a lamp. */
#define PEL_LAMP_REACH 96
#define PEL_LAMP_LEAST_PX 2.2
#define PEL_LAMP_SHOWN 1e-3
#define PEL_LAMP_SLACK 2e-3
#define PEL_LAMP_SPOTS 1024 /* PEL_MAX_LAMPS */
/* And those that the sea mirrors: texels of each, and the slopes that mirror
 * it, in standard deviations. */
#define PEL_GLOW_TEXELS 5
#define PEL_GLOW_TILE 32 /* pixels a side that know which */
#define PEL_LAMP_SLOPES 4.0
/* Of what one shows on average where all waves are level, by the inverse of the
 * slopes' deviations: 1 / 8π, over the least cosine of sights, over 1e-6 cd/m²
 * that no eye sees. And the least of its facets' reflectance. */
#define PEL_LAMP_MEAN (0.0398 / 0.05 / 1e-6)
#define PEL_LAMP_DULLEST 0.03

/* Drops and flakes near the eye (optics/falling.h): kinds by size; from
 * NEAREST m on, in shells about their axis from INMOST m on; how long the
 * shutter is open, s; diameter of the lens's opening, m, which blurs what is
 * near; a column's width in half-widths of a drop's blur; the square of a
 * pixel's blur, in pixels; after so many s a column has other drops. */
#define PEL_FALL_DROPS 4
#define PEL_FALL_FLAKES 3
#define PEL_FALL_KINDS 7
#define PEL_FALL_SHELLS 7
#define PEL_FALL_INMOST_M 0.125
#define PEL_FALL_NEAREST_M 1.0
#define PEL_FALL_FARTHEST_M 16.0 /* at most */
#define PEL_FALL_FADES 0.8       /* of the farthest: from there on */
#define PEL_FALL_SHUTTER_S (1.0 / 60)
#define PEL_FALL_LENS_M 2e-3
#define PEL_FALL_ACROSS 12.0
#define PEL_FALL_PIXEL 1.4
#define PEL_FALL_LIFE_S 4.0
/* Sines of angles from the axis that they fall along: what is nearer to it than
 * the first is not drawn, from the second on all is. */
#define PEL_FALL_SINE_LEAST 0.03
#define PEL_FALL_SINE_WHOLE 0.125

/* Drops on a pane before the camera (render/panemap.h), in tangents from its
 * axis: width of a runner's column; where the highest begin; beads that one
 * leaves; share of columns with one; how long one runs, s. */
#define PEL_PANE_RUN_WIDE 0.09
#define PEL_PANE_TOP 0.9
#define PEL_PANE_BEADS 48
#define PEL_PANE_RUNS 0.7
#define PEL_PANE_LIFE_S 9.0
#define PEL_PANE_SOFT 9e-4 /* of their edges, tangent */

/* vec4 that a probe answers with (probe.comp). */
#define PEL_PROBE_ANSWERS 6

#define PEL_WAVE_LIMIT 256

/* Slope variance left to the BRDF along and across the wind, by the footprint
 * of a pixel: PEL_VARIANCE_STEPS entries an octave from 2^PEL_VARIANCE_FIRST m.
 */
#define PEL_VARIANCE_FIRST -10.0
#define PEL_VARIANCE_STEPS 8.0
#define PEL_VARIANCE_COUNT 192

/* Levels of detail by which positions are sampled sharper than slopes. */
#define PEL_SHIFT_SHARPER 1.5

/* Areas (ocean/areas.h): their number at most, corners of each; the waves that
 * they change are shorter, those of the two finer cascades. */
#define PEL_AREA_LIMIT 16
#define PEL_AREA_CORNERS 16
#define PEL_AREA_SHORTER_M 3.709
#define PEL_AREA_FACTOR 2.0 /* at most */
#define PEL_AREA_FOAM 6.8   /* power of the factor by which foam changes */

/* Whitecaps (ocean/foam.h): the table of foam, nodes a side within REACH
 * standard deviations of X and Y, and by the standard deviation left; the share
 * of their variance that no footprint resolves; texels a side of foam's
 * structure, its tile across the wind, m. */
#define PEL_FOAM_SIDE 65
#define PEL_FOAM_LEVELS 12
#define PEL_FOAM_SHORTEST_M 3.709 /* waves that break are longer */
#define PEL_FOAM_REACH 4.4
#define PEL_FOAM_ALWAYS_LEFT 0.08
#define PEL_FOAM_GRAIN 512
#define PEL_FOAM_GRAIN_SEEN_M 4.0 /* by footprints up to */
#define PEL_FOAM_SURF_M 71.0      /* side of a tile of surf */
#define PEL_FOAM_THIN 0.02        /* variance of its edges */
#define PEL_FOAM_FINE_A 3.0       /* what is torn: integers, so that its tile */
#define PEL_FOAM_FINE_B 1.0       /* fits foam's own, and not along it */
#define PEL_FOAM_FINE_SEEN_M 1.0  /* by footprints up to */
#define PEL_FOAM_BLOWN 0.3        /* in spray, at PEL_SPRAY_WHOLE */
#define PEL_FOAM_RELIEF 0.3       /* thickest foam is so much brighter */
#define PEL_FOAM_ALBEDO 0.55      /* of dense foam (Koepke 1984) */
#define PEL_FOAM_RED 0.95 /* of its albedo, at 680 nm (Frouin et al. 1996) */
#define PEL_FOAM_GRAIN_M 16.0
/* Spray: from and at winds of, m/s; extinction at the surface there, 1/m;
 * height in which it falls e times, m. */
#define PEL_SPRAY_FROM 15.0
#define PEL_SPRAY_WHOLE 30.0
#define PEL_SPRAY_EXTINCTION 2.0e-3
#define PEL_SPRAY_HEIGHT_M 15.0
/* Streaks: a tile across and along the wind, m; wind from which there are any,
 * and at which they hold the SHARE of all foam, m/s; weight in the structure.
 */
#define PEL_FOAM_STREAK_ACROSS_M 127.0
#define PEL_FOAM_STREAK_ALONG_M 1700.0
#define PEL_FOAM_STREAK_FROM 13.0
#define PEL_FOAM_STREAK_WHOLE 20.0
#define PEL_FOAM_STREAK_SHARE 0.6
/* They bend to either side by, and once in, m along and across. */
#define PEL_FOAM_STREAK_BEND_M 6.0
#define PEL_FOAM_BEND_ALONG_M 310.0
#define PEL_FOAM_BEND_ACROSS_M 190.0
#define PEL_FOAM_STREAK_WEIGHT 0.9
#define PEL_FOAM_STREAK_THIN 0.25 /* added to the variance of edges */

/* Clouds: texels a side of the tile of their field; asymmetry of their drops'
 * scattering, by Henyey and Greenstein. */
#define PEL_CLOUD_TEXELS 512
#define PEL_CLOUD_ASYMMETRY 0.85
/* Tiles after which their field is the same again (lib/cloudfield.glsl). */
#define PEL_CLOUD_PERIOD 16.0
#define PEL_CLOUD_NODE 3.7e-3 /* rad between nodes at most: cloudscape.frag */
#define PEL_CLOUD_NODE_PX 16
#define PEL_CLOUD_WHITE 0.8 /* power of white balance under clouds */
/* Places within clouds that shine at a moment; the uniforms that have them:
 * metres from the eye's nadir, height, 1 or fewer; then light. */
#define PEL_CLOUD_GLOWS 16
#define PEL_UNIFORM_GLOW_COUNT 0
#define PEL_UNIFORM_GLOW_LIGHT 1
#define PEL_UNIFORM_GLOWS 2

/* Fog in layers and banks (optics/fog.h): how many; the share of a bank, by q,
 * that its edge is; Koschmieder's, for a contrast of 2 %; steps in which what
 * the sea mirrors of banks follows them, m. */
#define PEL_FOGS 4
#define PEL_FOG_RIM 0.5
#define PEL_KOSCHMIEDER 3.912
#define PEL_FOG_STEP_M 10.0
struct pel_shader_fog {
    vec4 shape; /* z extinction, 1/m; of a layer x base, y top, w width of its
                   edges, m; of a bank x height of its middle, m, y 1 over half
                   its height, 1/m */
    vec4 place; /* of a bank xy its middle from the eye's nadir, m; z 1/R²,
                   1/m²; 0: a layer, xy how much longer than upward the way
                   out of it is towards the lights */
};

/* The lights of the sky, each with a sky of its own that it makes in the air
 * (optics/light.h): the tables of sky and water have a layer for each, and what
 * is seen is their sum. */
#define PEL_LIGHT_SUN 0
#define PEL_LIGHT_MOON 1
#define PEL_LIGHTS 2
/* Shaders have them in the order of pel_lights_order: the one that casts
 * shadows first, then what adds to it. A program knows the first PEL_LIT of
 * them, and draws the discs of the first PEL_DISCS. */
#define PEL_LIGHT_FIRST 0
#ifndef __STDC__
#ifndef PEL_LIT
#define PEL_LIT 1
#endif
#ifndef PEL_DISCS
#define PEL_DISCS PEL_LIT
#endif
#endif
/* The night sky (optics/nightsky.h): rows of its map; pixels a side of a tile
 * that knows its stars. */
#define PEL_NIGHT_MAP_ROWS 48
#define PEL_STAR_TILE 16
struct pel_shader_light {
    vec4 direction;  /* xyz towards it; w angular radius, rad */
    vec4 irradiance; /* rgb above the air; w solid angle, sr */
    vec4 limb;       /* rgb darkening; w variance of slopes that mirror some of
                        the disc */
};

/* One for a frame. Spectral values are at 680, 550, 440 nm. */
PEL_BLOCK(PEL_BLOCK_FRAME, frame)
{
    PEL_STRUCT pel_shader_light lights[PEL_LIGHTS];
    vec4 wind;     /* xy unit, blows to; zw total slope variance along, cross */
    vec4 rayleigh; /* rgb scattering at sea level, 1/m; w scale height, m */
    vec4 mie;      /* x extinction, y scattering, 1/m; z scale height; w g */
    vec4 ozone;    /* rgb peak absorption, 1/m; w height of the peak, m */
    vec4 planet;   /* x ground, y top radius, m; z ozone half-width, m; w R0, of
                      the paper's fits */
    vec4 refraction; /* rgb squared refractive index of the surface */
    vec4 water; /* levels of depth (lib/water.glsl): x their number, y log2 of
                   the first, m, z levels an octave; w 1 leaves out the air */
    vec4 red;   /* rows of the matrix to Rec. 709 cd/m²; w of red, green: lives
                   of glints since the start, whole and the rest */
    vec4 green;
    vec4 blue;   /* w: share of the slope variance left that glints are drawn
                    from, 0 without sparkle */
    vec4 crests; /* of the waves' horizontal part, 3/4 of its squared share
                    (pel_sharpened): x of the finest waves, y what those of
                    a slope variance have more, by it; z variance of foam's
                    edges */
    vec4 dusk;   /* x power of two that light is times in textures of 16 bits, y
                    its inverse: 1 by day */
    vec4 sources[PEL_LIGHTS]; /* of lights that are lit: xyz from them towards
                                 the Sun, w radiance of their night side over
                                 that of their day; 0: it shines itself */
    vec4 whitecaps; /* x 1 over the deviation of what breaks; y weight of
                       streaks; z tiles of foam's structure a metre along the
                       wind; w mean share of the sea that dense foam hides */
    /* Of a picture's texels to radiance, rows; w: azimuth of its middle, log2
     * of its texels a radian. */
    vec4 panorama[3];
    /* Clouds (optics/clouds.h), declared where they are drawn. */
    vec4 cloud_shape; /* x rank from which on there are some, y one over what it
                         rises until they are thickest; z extinction, 1/m; w
                         softness of tops, m */
    vec4 cloud_size;  /* x base, y thickness at most, m; z tiles a metre across
                         the drift, w how much longer they are along it */
    vec4 cloud_light; /* x share of the light on a level plane that comes
                         through, y of the beam, means; z weight of the fine
                         structure */
};

/* One for an eye, a camera position of this frame. */
PEL_BLOCK(PEL_BLOCK_EYE, eye)
{
    vec4 eye;   /* x height above the sea, m; y dip of the horizon, rad; z angle
                   between the mesh's columns, rad; w columns around */
    vec4 lut;   /* x height the sky tables were made for, m;
                   z extinction of spray on the way to the sea, 1/m */
    vec4 grain; /* the eye's nadir in tiles of foam, xy, of streaks, zw */
    vec4 bends; /* x of streaks there, turns */
    vec4 eye_clouds; /* xy the nadir in tiles of the clouds' field, along their
                        drift and across, 0..PEL_CLOUD_PERIOD; zw that way,
                        unit */
    vec4 fog_layers; /* x optical depth of all layers, upward */
    PEL_STRUCT pel_shader_fog fogs[PEL_FOGS]; /* layers, then banks */
};

/* The sea from high up (render/spacegeometry.h, lib/space.glsl): maps of the
 * light on it by a light's elevation e [rad] as asinh((e + MIDDLE) / WIDTH)
 * from FIRST to LAST (-20 to 90 deg), texels a side; the table of the air of an
 * eye by azimuth from a light and by rows, of sights that meet the ground, of
 * those that pass it, of those that rise; steps along a sight. */
#define PEL_SPACE_SUNS 44
#define PEL_SPACE_SUN_MIDDLE 0.05
#define PEL_SPACE_SUN_WIDTH 0.25
#define PEL_SPACE_SUN_FIRST -1.013578
#define PEL_SPACE_SUN_LAST 2.568255
#define PEL_SPACE_MAP 64
#define PEL_SPACE_COLUMNS 96
#define PEL_SPACE_ROWS 192
#define PEL_SPACE_GROUND_ROWS 80
#define PEL_SPACE_LIMB_ROWS 64
#define PEL_SPACE_STEPS 32
/* Columns and rows of the Earth's winds; columns of the sea's roughness by wind
 * speed from 0 to MOST m/s. */
#define PEL_WIND_COLUMNS 720
#define PEL_WIND_ROWS 360
#define PEL_WIND_SPEEDS 61
#define PEL_WIND_MOST 30.0
#if defined(__STDC__) || defined(PEL_SPACE)
PEL_BLOCK(PEL_BLOCK_SPACE, space)
{
    vec4 space_eye;      /* x height above the sphere, m; y cosine of the zenith
                            angle of its horizon; z 1: each point has its own light,
                            0: that of the nadir; w greatest height of sights that
                            pass the ground, where they are nearest to it, m */
    vec4 space_from[3];  /* columns: of the eye's frame into the sphere's */
    vec4 space_earth[3]; /* columns: of the eye's frame into the Earth's axes */
    vec4 space_more;     /* x 1: there is land; y length from which on waves
                            are not seen one by one, m; z mean cover by fog, in
                            a meter by clouds too, w their reflectance */
    vec4 space_cloud;    /* x where systems of clouds begin; y their share in
                            where clouds are */
    vec4 space_lights[PEL_LIGHTS]; /* xyz towards them in the sphere's frame; w
                                      elevation at the nadir, rad */
    /* log2 of what the first of the lights' kind gives at strength 1, by its
     * elevation: rgb irradiance of the sky, then of all on the level plane. */
    vec4 space_suns[2 * PEL_SPACE_SUNS];
    vec4 space_origin; /* xyz of the scene, in the Earth's axes; w and the
                          next: noise of systems of clouds there, by octaves */
    vec4 space_systems[2];
    vec4 space_winds; /* x how far between two times of the winds; y the scene's
                         speed, m/s; zw slope variance of the scene's sea along,
                         across, by that of the table at this speed */
    vec4 space_sun; /* rgb its irradiance above the air; w illuminance where the
                       lights stand highest of all that is seen, lx */
};
#endif

/* One for a view. The pixel lattice is X right, Y down, in pixels from the
 * axis: a ray is right·X·px − up·Y·py − back. */
#define PEL_VIEW_MEMBERS                                                       \
    vec4 right;  /* camera axes in the world; w of right: N_min */             \
    vec4 up;     /* w: 1 / (N_max − N_min) */                                  \
    vec4 back;   /* w: levels of detail that slopes are sampled coarser */     \
    vec4 pixel;  /* px, py; lattice place of the picture's top left corner */  \
    vec4 size;   /* width, height, px; z 1: rims of lights are antialiased; w  \
                    nodes of the clouds' lattice a pixel */                    \
    vec4 sensor; /* x 0 none, 1 a sensor's grey, 2 no picture; grey · y + z; w \
                    noise */                                                   \
    vec4 sensor_seed; /* xy 0..65535; z share of lines that drop out; w        \
                         PEL_TONE_* */
#ifndef PEL_TOGETHER
PEL_BLOCK(PEL_BLOCK_VIEW, view)
{
    PEL_VIEW_MEMBERS
};
#endif

/* Views of one eye that are drawn together (render/together.h): each is a layer
 * of every dispatch, z of its groups, and has its part of every list. */
#define PEL_TOGETHER_MOST 8
#if defined(__STDC__) || defined(PEL_TOGETHER)
struct pel_shader_view {
    PEL_VIEW_MEMBERS
};
struct pel_shader_together {
    PEL_STRUCT pel_shader_view view;
    vec4 columns;  /* x angle between the mesh's columns, rad; y columns around */
    uvec4 first;   /* its first vertex, ring, pixel; w vertices */
    uvec4 picture; /* x pixels around it; y word of its readback buffer that gets
                      the EV100; z blocks of the mesh; w 1: outlines are sought
                      sideways too */
    uvec4 apart[2];                    /* of outline_find.comp, pairs */
    uvec4 blocks[PEL_MESH_MAX_BLOCKS]; /* first ring, rings, first column,
                                          columns */
    uvec4 bases[PEL_MESH_MAX_BLOCKS];  /* x first vertex, from the view's */
};
PEL_BLOCK(PEL_BLOCK_VIEW, together)
{
    PEL_STRUCT pel_shader_together together[PEL_TOGETHER_MOST];
};
#endif

/* A lamp that a view may show: from the eye, m, w how far; spectral intensity
 * towards it, w diameter, m; xy on the lattice, z share that the lens scatters.
 * And what of it reaches the eye: radiance, w px; halo's, w px; on the lattice,
 * z core of the halo, w of the whole, px. */
struct pel_shader_lamp {
    vec4 place, light, spot;
};
struct pel_shader_spot {
    vec4 light, halo, place;
};

/* What the meter of a view sees. */
struct pel_shader_sight {
    vec4 right; /* camera axes in the world; w tangent of the left edge */
    vec4 up;    /* w: right edge */
    vec4 back;  /* w: top edge */
    vec4 below; /* x: bottom edge */
};
#define PEL_SIGHTED_MEMBERS                                                    \
    vec4 meter; /* x number of windows, 0: fixed; y fixed EV100; z PEL_TONE_*; \
                   w share of light that the lens scatters */                  \
    vec4 rod;   /* rgb weights of the scotopic luminance; w PEL_VISION_* */    \
    PEL_STRUCT pel_shader_sight sights[PEL_METER_SIGHTS];
#if defined(__STDC__) || defined(PEL_METER)
#ifndef PEL_TOGETHER
PEL_BLOCK(PEL_BLOCK_SIGHTS, sighted)
{
    PEL_SIGHTED_MEMBERS
};
#endif
#if defined(__STDC__) || defined(PEL_TOGETHER)
struct pel_shader_sighted {
    PEL_SIGHTED_MEMBERS
};
PEL_BLOCK(PEL_BLOCK_SIGHTS, all_sighted)
{
    PEL_STRUCT pel_shader_sighted all_sighted[PEL_TOGETHER_MOST];
};
#endif
#endif

/* Written by the meter. */
struct pel_shader_glare {
    vec4 direction; /* xyz towards its source; w 1 − cos of its radius */
    vec4 light; /* rgb at its centre as the radiance of a pixel; w share taken
                   from the source */
};
#define PEL_EXPOSURE_MEMBERS                                                   \
    vec4 exposure; /* x EV100; y log2 of the mean, z of the highlights, cd/m²  \
                    */                                                         \
    vec4 exposing; /* rgb exposed light of 1 cd/m², balanced */                \
    vec4 rods;     /* as `rod` of the block sighted */                         \
    PEL_STRUCT pel_shader_glare glare[PEL_GLARES];
#ifndef PEL_TOGETHER
PEL_BLOCK(PEL_BLOCK_EXPOSURE, exposure)
{
    PEL_EXPOSURE_MEMBERS
};
#else
struct pel_shader_exposure {
    PEL_EXPOSURE_MEMBERS
};
PEL_BLOCK(PEL_BLOCK_EXPOSURE, exposures)
{
    PEL_STRUCT pel_shader_exposure exposures[PEL_TOGETHER_MOST];
};
#endif

/* A wave as the shaders sum it, read as texels. One list for an eye, longest
 * first, and a wave of no length after the last. What is read costs more than
 * arithmetic; whole turns of a phase mean nothing, so they hold a number. */
#define PEL_CHOP_STEPS 64 /* chop is a multiple of 1/64 */
#ifdef __STDC__
struct pel_shader_wave {
    vec4 phase;  /* k / 2π xy, 1/m; phase at the eye's nadir now, turns, and
                    PEL_CHOP_STEPS · chop whole ones; λ, m */
    vec4 wander; /* ocean/wander.h: m xy, 1/m; s − ½ there now and swing / π
                    whole turns; 2π h, m */
};
struct pel_block_waves {
    struct pel_shader_wave waves[PEL_WAVE_LIMIT + 1];
};
#endif

/* The cascades (ocean/cascade.h): how many, modes along a side, levels of
 * detail (256, 128 .. 1). */
#define PEL_CASCADES 4
#define PEL_CASCADE_N 256
/* Each tile is this times shorter than the one before; the last is
 * PEL_CASCADE_HIGHEST · PEL_SEA_SHORTEST_M = 1.76 m long, the first 4.4 km. */
#define PEL_CASCADE_RATIO 13.618
#define PEL_CASCADE_LEVELS 9

/* How many times shorter the second shear of each is than the first, to which
 * it is normal (ocean/shear.h). */
#define PEL_SHEAR_RATIO 1.29

/* One for an eye, instead of the waves, where the sea is made of FFT cascades
 * (ocean/cascade.h). */
struct pel_shader_cascade {
    vec4 place;  /* xy turn; z 1 / length, 1/m; w texel, m */
    vec4 offset; /* xy place of the eye's nadir, in tiles; zw its turns of the
                    two shears (ocean/shear.h) */
    vec4 shear;  /* xy f of the first, 1/m; z shear / |f|², m² */
};
/* Longest wave of all cascades but the first, in lengths of the tile. */
#define PEL_LONGEST_OF_CASCADE 0.1548
PEL_BLOCK(PEL_BLOCK_CASCADES, cascades)
{
    PEL_STRUCT pel_shader_cascade cascades[PEL_CASCADES];
};

/* Tiles of ship waves (ocean/wake.h), three a ship, relative to the nadir. */
#define PEL_WAKE_N 256
#define PEL_WAKE_LAYERS 24
/* Their mean square slopes, in a level of the texture. */
#define PEL_WAKE_ROUGH_LEVEL 3
#define PEL_WAKE_ROUGH_N 32
/* Cells of a side of a grid over all tiles, row by row: the layers that may
 * reach each as the bits of a number. */
#define PEL_WAKE_CELLS 32
#define PEL_WAKE_FADE 0.41
#define PEL_WAKE_FADED 0.46
struct pel_shader_wake {
    vec4 place;  /* xy its middle, m; z texels a metre; w its side, m */
    vec4 offset; /* xy the nadir in texels */
};
#if defined(__STDC__) || defined(PEL_WAKES)
PEL_BLOCK(PEL_BLOCK_WAKES, wakes)
{
    vec4 wake_grid; /* xy its corner, m; zw cells a metre; 0: no layers */
    PEL_STRUCT pel_shader_wake wakes[PEL_WAKE_LAYERS];
    vec4 wake_cells[PEL_WAKE_CELLS * PEL_WAKE_CELLS / 4];
};
#endif

/* The wash of ships (ocean/wash.h): words of a node; how far the edges of its
 * bands billow, of their half-width, by two waves, 1/m; a footprint makes them
 * softer by so much, m; foam makes short waves higher by so much of it; foam's
 * structure is that of a second tile, m, too, which has this weight. */
#define PEL_WASH_NODE_WORDS 12
#define PEL_WASH_BEND 0.09
#define PEL_WASH_BEND_1_X 0.0195
#define PEL_WASH_BEND_1_Y 0.0146
#define PEL_WASH_BEND_2_X -0.0294
#define PEL_WASH_BEND_2_Y 0.0512
#define PEL_WASH_SOFTEST_M 6.0
#define PEL_WASH_CHURNED 0.4
#define PEL_WASH_GRAIN_M 61.0
#define PEL_WASH_GRAIN_WEIGHT 0.66
#if defined(__STDC__) || defined(PEL_WASH)
PEL_BLOCK(PEL_BLOCK_WASH, wash)
{
    vec4 wash_box;   /* xy its corner from the eye's nadir, m; z cells a metre;
                        w first cell, a word */
    vec4 wash_size;  /* xy columns, rows; z first of the list, a word */
    vec4 wash_grain; /* the eye's nadir in tiles of foam, of the other tile */
    vec4 wash_bends; /* xy turns of the bends there */
    vec4 wash_water; /* rgb radiance that bubbles send up, of irradiance 1 */
};
#endif

/* Bands of waves that are read together over a bottom (ocean/shore.h), and the
 * grid of what they are there. */
#define PEL_SHORE_BANDS 4
#define PEL_SHORE_WAVES 256
#if defined(__STDC__) || defined(PEL_SHORE)
PEL_BLOCK(PEL_BLOCK_SHORE, shore)
{
    vec4 shore_grid; /* xy the nadir in nodes; z nodes a metre */
    vec4 shore_size; /* xy nodes */
    vec4 shore_bands[PEL_SHORE_BANDS]; /* xy direction; z rad/m */
    /* Bands of trochoids, three bits each, eight in a number. */
    vec4 shore_waves[PEL_SHORE_WAVES / 32];
};
#endif

/* Gauss quadrature over the facets an eye sees (optics/facets.h), by
 * q = μ / (1 + μ) in PEL_FACET_STEPS equal steps from 0 to 1; the shaders read
 * it as texels. */
#define PEL_FACET_STEPS 64
#ifdef __STDC__
struct pel_shader_facets {
    vec4 node;   /* slopes towards the eye, standard deviations; w: of those
                    whose reflection meets another wave */
    vec4 weight; /* sum 1 over what is seen */
};
struct pel_block_facets {
    struct pel_shader_facets facets[PEL_FACET_STEPS + 1];
};
#endif

/* One for an eye, where the sea has areas (ocean/areas.h). */
struct pel_shader_area {
    vec4 place; /* xy from the eye's nadir; z radius, of a polygon's farthest
                   corner; w edge, m */
    vec4 shape; /* x factor less 1; y corners, 0: a circle */
};
#if defined(__STDC__) || defined(PEL_AREAS)
PEL_BLOCK(PEL_BLOCK_AREAS, areas)
{
    vec4 area_count; /* x; zw slope variance of short waves, along, cross */
    PEL_STRUCT pel_shader_area areas[PEL_AREA_LIMIT];
    vec4 area_corners[PEL_AREA_LIMIT * PEL_AREA_CORNERS / 2]; /* two each, from
                                                                 the place */
};
#endif

/* Written by the light pass. */
PEL_BLOCK(PEL_BLOCK_LIGHT, light)
{
    vec4 incident;  /* x illuminance of the level plane, lx */
    vec4 sea_light; /* rgb the water's radiance, seen at 37° across a light */
    vec4 beams[PEL_LIGHTS]; /* rgb irradiance normal to its beam, sea level */
    vec4 skies[PEL_LIGHTS]; /* rgb horizontal irradiance of its sky */
    vec4 open_sky;          /* rgb that of all above fog, below clouds; w share
                               of the first light's beam at own ship's place */
};

/* Levels of seabed_tops, the highest nodes of squares: level k has one for each
 * square of 2^(k+1) spaces between nodes, borders and all. */
#define PEL_SEABED_TOP_LEVELS 11

/* The light of level water made that of a slope (optics/waterslope.h): found by
 * least squares against the Monte Carlo over planes, ridges and steps
 * (docs/physics/bottom.md). In units of a reduced optical depth, light comes
 * from where the bottom lies less deep under the line of sight (UNDER) and uphill
 * (STEEP); ABSORBED is the share of absorption in it. */
#define PEL_SLOPE_ABSORBED 0.45
#define PEL_SLOPE_BOTTOM_UNDER 0.25
#define PEL_SLOPE_BOTTOM_STEEP 0.2
#define PEL_SLOPE_VOLUME_UNDER 0.18
#define PEL_SLOPE_VOLUME_STEEP 0.39
#define PEL_SLOPE_SHIFT_LEAST -1.0
#define PEL_SLOPE_SHIFT_MOST 0.6

/* Depths, PEL_FOCUS_STEPS an octave from 2^PEL_FOCUS_FIRST m. */
#define PEL_FOCUS_FIRST -2.0
#define PEL_FOCUS_STEPS 2.0
#define PEL_FOCUS_COUNT 20

/* One for an eye over a height field (render/seabedmap.h). */
PEL_BLOCK(PEL_BLOCK_SEABED, seabed)
{
    vec4 bed_place;  /* xy the eye's nadir in nodes; z nodes a metre; w metres
                        between nodes */
    vec4 bed_size;   /* columns, rows; z highest, above the sea's zero, m; w the
                        file's zero above it, m */
    vec4 bed_beyond; /* x height beyond the field, m; y up to where waves wet
                        the land, m; z levels of seabed_tops; w 1: caustics */
    vec4 bed_wet;    /* rgb albedo of wet land */
    vec4 bed_dry;    /* rgb of dry land */
    vec4 bed_under;  /* rgb under water */
    vec4 bed_level[PEL_SEABED_TOP_LEVELS]; /* of seabed_tops: x place of the
                                              first, y columns, z rows */
    vec4 bed_focus[PEL_LIGHTS * PEL_FOCUS_COUNT]; /* by light and depth: x log2
                                        of the footprint, m, whose waves focus
                                        light without crossing rays */
    vec4 bed_extinction;                          /* rgb of the water, 1/m */
    vec4 bed_beams[PEL_LIGHTS]; /* x radiance above the water that a beam of
                                   unit irradiance leaves on a white level
                                   bottom, 1/sr; y 1 where slopes are steeper
                                   than the beam in the water */
    vec4 bed_fall; /* rgb of scattered light by length, octaves a metre; w the
                      number of cascades */
    vec4 bed_absorption; /* rgb, 1/m; 0 where only two orders are drawn */
    vec4 bed_turned;     /* rgb scattering (1 − asymmetry), 1/m, or 0 */
};

/* Objects on the sea (render/objects.h): texels of a vertex (place, ambient
 * light that reaches it; normal as an octahedron's place, texture's place), of
 * a material, of an entity in a view; texels a side of what surrounds them, an
 * octahedron; terms of its light by the normal. */
#define PEL_OBJECT_VERTEX_TEXELS 2
#define PEL_OBJECT_MATERIAL_TEXELS 2
#define PEL_PAINT_LEVELS 12 /* of a texture, at most */
#define PEL_PAINT_SIZES 16
#define PEL_OBJECT_PLACE_TEXELS 19
/* Wet hulls (optics/wet.h): waves that may have washed over a place, some two
 * minutes of them, chosen for how long a film of water stays; diffuse
 * reflectances of water from the air and from inside; a film's roughness. */
#define PEL_WET_WAVES 20
#define PEL_WET_OUTSIDE 0.0667
#define PEL_WET_INSIDE 0.4802
#define PEL_WET_ROUGH 0.2
#define PEL_SAMPLES 4 /* of a pixel of objects */
#define PEL_SURROUNDINGS_SIZE 64
#define PEL_SURROUNDINGS_TERMS 9
/* Hulls seen from below: texels along and across; height where there is none;
 * rows of each side, by depth. */
#define PEL_NO_HULL 1e9
#define PEL_HULL_LENGTH 256
#define PEL_HULL_BREADTH 128
#define PEL_HULL_ROWS 64
/* Mirrored views of objects, texels, and their levels of detail. */
#define PEL_MIRROR_WIDTH 512
#define PEL_MIRROR_HEIGHT 256
#define PEL_MIRROR_LEVELS 9
/* A shadow's texels a side. */
#define PEL_SHADOW_SIZE 1024
PEL_BLOCK(PEL_BLOCK_SURROUNDINGS, surroundings)
{
    /* rgb light on a surface by its normal, over pi: spherical harmonics, the
     * cosine folded in; then of that from below the horizon alone */
    vec4 ambient[2 * PEL_SURROUNDINGS_TERMS];
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
#define PEL_WATER_SKY_COLUMNS 32 /* in half a circle */
/* Steps of the table of the phase function, over the sine of half the angle. */
#define PEL_WATER_TURNS 1024
/* Most depths that there are maps for. */
#define PEL_WATER_LEVELS_MAX 24
/* Parts of the light, as layers of the maps after their sum and as layers of
 * pictures (optics/watertable.h). */
#define PEL_PART_SINGLE 0  /* scattered once */
#define PEL_PART_SECOND 1  /* scattered twice */
#define PEL_PART_HIGHER 2  /* more often, or mirrored from below */
#define PEL_PART_BOTTOM 3  /* reflected by the bottom, scattered or not */
#define PEL_WATER_LAYERS 5 /* of the maps, a depth: the sum, then the parts */
/* Only of the buffer of the answers (optics/waterkernel.h): reflected by the
 * bottom, and not scattered. */
#define PEL_PART_STRAIGHT 4
#if defined(__STDC__) || defined(PEL_MEDIUM)
PEL_BLOCK(PEL_BLOCK_MEDIUM, medium)
{
    vec4 full_extinction;   /* rgb, 1/m; w 1: every order is drawn */
    vec4 single_extinction; /* rgb, of single scattering */
    vec4 scattering;        /* rgb, 1/m */
    vec4 ground;            /* rgb albedo of the bottom */
    vec4 peak; /* rgb share of the phase function's peak: what it leaves is in
                  the table of PEL_STORE_WATER_TURNS */
    vec4 depth[PEL_WATER_LEVELS_MAX]; /* x m, of each level */
};
#endif
/* Light that an eye under water sees (optics/underlight.h): levels of depth;
 * rows of directions up, and down, by x from 0 to 1 at the elevation π/2
 * x^POWER; columns of azimuths from a light's, 0 to π; modes; nodes of beams
 * are those of the other maps. Two more rows hold irradiances of level planes,
 * from above and from below. Steps of the phase function, evenly in the root of
 * the angle. */
#define PEL_UNDER_LEVELS 20
#define PEL_UNDER_ROWS 32
#define PEL_UNDER_POWER 1.5
#define PEL_UNDER_COLUMNS 32
#define PEL_UNDER_MODES 12
#define PEL_UNDER_TURNS 64
/* What the waves focus in the water about the eye: places on the surface
 * through which the light comes, REACH m away at the edge and denser near the
 * eye, by depth, DEPTHS steps of STEPS an octave from FIRST m. */
#define PEL_SHAFT_PLACES 192
#define PEL_SHAFT_REACH 20.0
#define PEL_SHAFT_DEPTHS 14
#define PEL_SHAFT_STEPS 2.0
#define PEL_SHAFT_FIRST 0.5
#define PEL_SHAFT_MEAN 7 /* level of detail of their means */
#define PEL_SHAFT_SHARPER 0.4
#define PEL_SHAFT_MOST 6.0
/* What a line of sight meets in the water. */
#define PEL_UNDER_NOTHING 0.0
#define PEL_UNDER_SURFACE 1.0
#define PEL_UNDER_BOTTOM 2.0
/* Suspended particles that are seen one by one: the smallest; drawn as far as
 * one is a pixel over SEEN wide, from NEAREST on; at most so many a picture; how
 * much of what falls on one it scatters; mean cosines of the light around it,
 * from above and from below (Mobley 1994, section 3.2). */
#define PEL_MOTE_LEAST_M 0.5e-3
#define PEL_MOTE_SEEN 4.0
#define PEL_MOTE_NEAREST_M 0.12
#define PEL_MOTE_MOST 81920
#define PEL_MOTE_WHITE 0.8
#define PEL_MOTE_COSINE_DOWN 0.8
#define PEL_MOTE_COSINE_UP 0.45
/* Beyond a picture's edges that middles of particles may lie, px; and how wide
 * one is at most. */
#define PEL_MOTE_MARGIN 64
/* Radius of the dome before a lens that waves may cross, m. */
#define PEL_UNDER_DOME 0.1
/* Lamps in the water that light it. */
#define PEL_UNDER_LAMPS 8
#if defined(__STDC__) || defined(PEL_UNDER)
PEL_BLOCK(PEL_BLOCK_UNDER, under)
{
    vec4 under_eye;     /* x depth below the mean sea, m; y the water's surface
                           above the eye, m; zw its slope there */
    vec4 under_lens;    /* x 1: the surface crosses the lens; y lamps in the
                           water; w 1: shafts */
    vec4 under_scaled;  /* rgb extinction without the forward peak, 1/m */
    vec4 under_full;    /* rgb extinction, 1/m */
    vec4 under_scatter; /* rgb scattering, 1/m */
    vec4 under_fall;    /* rgb by which the levels are scaled, 1/m */
    vec4 under_levels;  /* x one over the step near the surface, 1/m; y levels
                           an octave; z last level; w share of the second
                           kernel */
    vec4 under_ground;  /* rgb albedo of the bottom; w its depth below the mean
                           sea, m */
    vec4
        under_drift; /* x depth of the eye in the light, m; w variance of slopes
                        that would spread a beam as the forward peak does */
    vec4 under_beams[PEL_LIGHTS]; /* xyz towards it, in the water; w irradiance
                                     normal to it for 1 above the surface */
    vec4 under_turns[PEL_UNDER_TURNS + 1]; /* rgb log2 of the phase function
                                              without its peak */
    vec4 under_lamps[PEL_GLOW_TEXELS * PEL_UNDER_LAMPS]; /* as lamp_glows */
};
#endif
PEL_BLOCK(PEL_BLOCK_BEAM, beam)
{
    vec4 refracted;   /* the beam of a light in the water: x sine, y cosine of
                         its zenith angle; z irradiance normal to it for 1 above
                         the surface */
    vec4 at_nodes[3]; /* weights of the nodes that make its sine */
};
/* A row of the sky or of the map: its place among the nodes. */
struct pel_shader_row {
    vec4
        at; /* sky: x elevation, rad, y what a texel's radiance adds to the
               beam below; map: x sine, y cosine of its zenith angle in water */
    vec4 at_nodes[3];
};

#ifdef __STDC__
#undef vec4
#undef uvec4
#undef PEL_STRUCT
#endif
