// Foam seen from below: a layer of bubbles that absorbs little, on all sides of
// which light leaves it alike (Kokhanovsky 2004). From above it sends back R, as
// pictures from above have it, and takes A = R (1 / PEL_FOAM_RED - 1) at 680 nm;
// the rest, T = 1 - R - A, goes into the water. Upwards goes T / n2, since light in
// water comes from n2 times as many directions (reciprocity of two media), and back
// down 1 - A - T / n2.
void foam_below(float bright, out vec3 down, out vec3 back_)
{
    vec3 up_ = vec3(bright * PEL_FOAM_ALBEDO) * vec3(PEL_FOAM_RED, 1.0, 1.0);
    vec3 taken = vec3(bright * PEL_FOAM_ALBEDO) - up_;
    down = 1.0 - up_ - taken;
    back_ = 1.0 - taken - down / refraction.g;
}

// It hides what the surface lets through and mirrors. x: its share, y: how bright
// it is from above; below: the water's irradiance on it, lamps: that of lamps.
void cover_by_foam_below(vec2 foam, vec3 below, vec3 lamps, inout under_light l)
{
    vec3 down, back_, sun = vec3(0.0), sky = vec3(0.0);
    foam_below(foam.y, down, back_);
    for (int i = 0; i < PEL_LIT; i++) {
        sun += beam_there(i) * max(lights[i].direction.z, 0.0);
        sky += skies[i].rgb;
    }
    under_light of_foam = UNDER_DARK;
    of_foam.sun = down * sun / PI;
    of_foam.sky = down * sky / PI;
    of_foam.more = back_ * below / PI;
    of_foam.once = back_ * lamps / PI;
    l = under_sum(under_sum(UNDER_DARK, l, vec3(1.0 - foam.x)), of_foam, vec3(foam.x));
}
