// The light of foam, and what it hides.

// Foam hides what the water mirrors and what leaves it, and is lit by Sun and
// sky like chalk. x: its share; y: how bright it is.
void cover_by_foam(vec2 foam, vec3 n, vec2 tilt, inout lit parts)
{
    if (foam.x <= 0.0) {
        return;
    }
    float open = 1.0 - foam.x;
    vec3 tint = foam.x * foam.y * PEL_FOAM_ALBEDO / PI * vec3(PEL_FOAM_RED, 1.0, 1.0);
    vec3 sun = vec3(0.0);
    vec3 sky = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        sun += beam_there(i) * max(dot(n, light_above(i, tilt)), 0.0);
        sky += skies[i].rgb;
    }
#ifdef PEL_LAMPS
    sun += lamps_on_face(lamps_from, n);
#endif
    parts.sun = parts.sun * open + tint * sun;
    parts.sky = parts.sky * open + tint * sky * (0.5 + 0.5 * n.z);
    parts.water *= open;
}
