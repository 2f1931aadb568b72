// What shading fragments reads of the uniform blocks, passed on flat by
// shade.vert: software devices read a block's members one by one and lane by
// lane, even where all lanes want the same, and flat inputs in one go.
// OpenGL promises room for 32.
#ifdef PEL_PASSES_FLAT
#define PEL_FLAT flat out
#else
#define PEL_FLAT flat in
#endif

// One light alone has room.
#if PEL_LIT == 1 && PEL_DISCS == 1
#define PEL_FLAT_LIGHT
#endif

#ifdef PEL_FLAT_LIGHT
PEL_FLAT pel_shader_light flat_lights[1];
#endif
PEL_FLAT vec4 flat_wind;
PEL_FLAT vec4 flat_planet;
PEL_FLAT vec4 flat_refraction;
PEL_FLAT vec4 flat_water;
PEL_FLAT vec4 flat_red;
PEL_FLAT vec4 flat_green;
PEL_FLAT vec4 flat_blue;
PEL_FLAT vec4 flat_eye;
PEL_FLAT vec4 flat_right;
PEL_FLAT vec4 flat_up;
PEL_FLAT vec4 flat_back;
PEL_FLAT vec4 flat_pixel;
PEL_FLAT vec4 flat_exposing;
#ifdef PEL_FLAT_LIGHT
PEL_FLAT pel_shader_glare flat_glare[1];
PEL_FLAT vec4 flat_beams[1];
#endif
#ifdef PEL_FFT
PEL_FLAT pel_shader_cascade flat_cascades[PEL_CASCADES];
#endif

#ifndef PEL_PASSES_FLAT
#ifdef PEL_FLAT_LIGHT
#define lights flat_lights
#define glare flat_glare
#define beams flat_beams
#endif
#define wind flat_wind
#define planet flat_planet
#define refraction flat_refraction
#define water flat_water
#define red flat_red
#define green flat_green
#define blue flat_blue
#define eye flat_eye
#define right flat_right
#define up flat_up
#define back flat_back
#define pixel flat_pixel
#define exposing flat_exposing
#define cascades flat_cascades
#endif
