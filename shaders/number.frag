#version 450 core
// The entity and its triangle.
flat in uvec2 number;
layout(location = 0) out uvec2 seen;

void main()
{
    seen = number;
}
