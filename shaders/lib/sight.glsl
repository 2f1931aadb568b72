// Which samples of a pixel show an object: those that the sea, where the
// pixel's middle meets it, does not hide. Includers have lib/ray.glsl, lib/cut.glsl,
// triangle_at, lib/model.glsl and lib/samples.glsl.

layout(binding = PEL_UNIT_OBJECT_DEPTHS) uniform sampler2DMS object_depths;

const float NEAR = 0.05;

uint samples_in_sight(ivec2 at)
{
    uint triangle = triangle_at(at);
    uint shown = 0u;
    for (int i = 0; i < PEL_SAMPLES; i++) {
        shown |= texelFetch(object_depths, at, i).r > 0.0 ? 1u << i : 0u;
    }
    uint behind = 0u;
    float in_sea = 0.0; // distance of the sea at the last sample behind it
    if (triangle != 0u && shown != 0u) {
        // The sea's triangle goes on as far as the pixel does.
        vec3 middle = pixel_ray(lattice(at));
        cut sea = cut_triangle(middle, triangle);
        float level = sea.t * dot(sea.facet, middle);
        for (int i = 0; i < PEL_SAMPLES; i++) {
            float slant = dot(sea.facet, pixel_ray(pixel.zw + vec2(at) + sample_place(i)));
            float t = clamp(slant == 0.0 ? sea.t : level / slant, 0.5 * sea.t, 2.0 * sea.t);
            bool is = (shown >> i & 1u) != 0u && t < NEAR / texelFetch(object_depths, at, i).r;
            behind |= is ? 1u << i : 0u;
            in_sea = is ? t : in_sea;
        }
    }
    // Dry in the hull for all of them or none.
    if (behind != 0u) {
        int i = findMSB(behind);
        uvec2 seen = texelFetch(object_samples, at, i).rg;
        vec3 ray = pixel_ray(pixel.zw + vec2(at) + sample_place(i));
        bool dry = hull_keeps_dry(int(seen.x) - 1, in_sea * ray, NEAR / texelFetch(object_depths, at, i).r * ray,
                                  (seen.y & SAMPLE_INNER) != 0u);
        shown &= dry ? ~0u : ~behind;
    }
    return shown;
}
