import sys
open(sys.argv[1], "w").write("/* generated */\nint pel_shaders_placeholder;\n")
