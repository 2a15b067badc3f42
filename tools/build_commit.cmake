# Writes OUTPUT, the source that says of which commit SOURCE is; left as it is while that does not change.
set(commit "")
if(EXISTS ${SOURCE}/.git)
  execute_process(COMMAND git -C ${SOURCE} describe --always --abbrev=8 --exclude=* --dirty=+
                  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#include \"build.hpp\"\n\nconst char* const build_commit = \"@commit@\";\n" @ONLY)
