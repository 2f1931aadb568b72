#if defined(PEL_LAMPS) || defined(PEL_LAMPS_BELOW)
// Twin of pel_lamp_towards: share of a lamp's intensity in a direction from it.
float lamp_towards(vec3 dir, vec4 light, vec4 axis, vec4 up, float spread)
{
    float along = dot(dir, axis.xyz), rise = dot(dir, up.xyz);
    float beam = fast_acos(clamp(along, -1.0, 1.0)) / max(light.w, 1e-4);
    float flat_ = along * inversesqrt(max(1.0 - rise * rise, 1e-12));
    float beyond = fast_acos(clamp(flat_, -1.0, 1.0)) - axis.w;
    float sector = clamp(1.0 - beyond / up.w, 0.0, 1.0);
    float off = max(0.5 * PI - fast_acos(clamp(abs(rise), 0.0, 1.0)) - spread, 0.0) / spread;
    return light.w > 0.0 ? exp2(-beam * beam) : sector * exp2(-off * off);
}
#endif
