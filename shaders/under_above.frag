#version 450 core
flat in uvec2 number;
in float height;
layout(location = 0) out uvec2 seen;

void main()
{
    if (height < 0.0) {
        discard;
    }
    seen = number;
}
