// The attachments of a fragment shader that shades: colour, or radiance and the
// layers that the slots of this pass name.
#ifdef PEL_RADIANCE
layout(location = 0) out vec4 radiance_out;
#endif
#ifdef PEL_COLOR
#ifdef PEL_RADIANCE
#define PEL_COLOR_PLACE 1
#else
#define PEL_COLOR_PLACE 0
#endif
layout(location = PEL_COLOR_PLACE) out vec4 color_out;
#endif
#ifdef PEL_LAYERS
layout(location = PEL_UNIFORM_SLOTS) uniform int slots[PEL_FRAGMENT_SLOTS];
layout(location = 1) out vec4 slot_out[PEL_FRAGMENT_SLOTS];
#endif

// `shows`: PEL_SHOWS_*.
void write_outputs(shaded s, ivec2 at, float shows)
{
#ifdef PEL_RADIANCE
    radiance_out = vec4(s.radiance, shows);
#endif
#ifdef PEL_COLOR
    color_out = vec4(display(s.radiance, at), 1.0);
#endif
#ifdef PEL_LAYERS
    for (int i = 0; i < PEL_FRAGMENT_SLOTS; i++) {
        slot_out[i] = layer_of(s, slots[i]);
    }
#endif
}
