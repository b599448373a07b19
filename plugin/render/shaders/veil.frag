#version 330 core
// A picture of a volume over what lies behind it: blended by its alpha.
in vec2 screen;
out vec4 color;
uniform sampler2D veil;
void main() { color = texture(veil, 0.5 + 0.5 * screen); }
