#version 450 core
flat in uint triangle;
layout(location = 0) out uint id;

void main()
{
    id = triangle;
}
