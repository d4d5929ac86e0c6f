# Writes a C++ file that names the sources of the photon stage and how they are compiled:
#   cmake -DOUT=photon_sources.cpp -DROOT=… -DCOMPILER="id version options" -P photon_sources.cmake
file(GLOB_RECURSE SOURCES RELATIVE ${ROOT} ${ROOT}/core/base/* ${ROOT}/core/math/* ${ROOT}/core/scene/*
     ${ROOT}/core/trace/* ${ROOT}/core/photon/*)
list(SORT SOURCES)
list(APPEND SOURCES CMakeLists.txt)   # the options
set(TEXT "${COMPILER}\n")
foreach(SOURCE ${SOURCES})
  file(SHA256 ${ROOT}/${SOURCE} DIGEST)
  string(APPEND TEXT "${SOURCE} ${DIGEST}\n")
endforeach()
string(SHA256 DIGEST "${TEXT}")
file(WRITE ${OUT}
     "namespace photond {\nextern const char* const kPhotonSources;\nconst char* const kPhotonSources = \"${DIGEST}\";\n}  // namespace photond\n")
