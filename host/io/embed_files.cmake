# SPDX-License-Identifier: Apache-2.0
# Writes OUTPUT: the function FUNCTION of HEADER, which returns a C++ table (path below ROOT, text) of the files below ROOT
# whose names end in one of ENDINGS (separated by commas).
string(REPLACE "," ";" ENDINGS "${ENDINGS}")
list(TRANSFORM ENDINGS PREPEND "${ROOT}/*." OUTPUT_VARIABLE patterns)
file(GLOB_RECURSE files RELATIVE ${ROOT} ${patterns})
list(SORT files)
set(table "#include \"${HEADER}\"\nnamespace eikon {\nconst std::map<std::string, std::string>& ${FUNCTION}() {\n  static const std::map<std::string, std::string> table = {\n")
foreach(file ${files})
  file(READ ${ROOT}/${file} text)
  string(APPEND table "{\"${file}\", R\"EIKON(${text})EIKON\"},\n")
endforeach()
string(APPEND table "  };\n  return table;\n}\n}\n")
file(WRITE ${OUTPUT} "${table}")
