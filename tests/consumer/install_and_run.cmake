# cmake -DBUILD=... -DSOURCE=... -DCONFIG=... -DCXX=... -DFLAGS=... -P: installs the libraries below
# the build folder, and builds and runs the consumers against the installed package.
set(prefix ${BUILD}/consumer/prefix)
set(build ${BUILD}/consumer/build)
file(REMOVE_RECURSE ${BUILD}/consumer)

function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix} --component library)
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${build} -G Ninja -DCMAKE_BUILD_TYPE=${CONFIG}
  -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER} -DCMAKE_CXX_FLAGS=${FLAGS}
  -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF)
run(${CMAKE_COMMAND} --build ${build})
run(${build}/walk)
run(${build}/velocity)

# With each estimator, library and command give exactly the same numbers.
set(walk ${BUILD}/consumer/walk)
run(${BUILD}/bin/chasles simulate hallway --images --quiet -o ${walk} --set hall_length=8
  --set sections=1 --set rest_duration=1 --set frame_rate=15)
foreach(estimator filter window:20 batch)
  string(REPLACE ":" "_" name ${estimator})
  run(${BUILD}/bin/chasles run ${walk} --quiet --estimator ${estimator} -o ${BUILD}/consumer/${name})
  run(${build}/run ${walk} ${estimator} ${BUILD}/consumer/${name}/trajectory.tum)
endforeach()
