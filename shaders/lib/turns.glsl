// sin and cos 2π x: minimax polynomials over a turn, |error| < 7e-6 and 5e-5: a
// twentieth of a millimetre of a metre-high wave.
vec2 sine_cosine_turns(float x)
{
    float r = x - roundEven(x);
    float z = r * r;
    return vec2(r * (6.28305598 + z * (-41.3312198 + z * (81.3668357 + z * (-74.4779238 + z * 32.780946)))),
                0.999959796 + z * (-19.7310418 + z * (64.6734326 + z * (-82.4035570 + z * 45.6456656))));
}
