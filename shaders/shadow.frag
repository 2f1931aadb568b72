#version 450 core
// Only the depth is kept.
void main()
{
}
