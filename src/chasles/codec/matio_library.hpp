#pragma once

#include <matio.h>

namespace chasles {

/// The functions of libmatio that MatFile uses. The library is loaded when the first .mat file is
/// read: HDF5, on which it is built, brings 30 more (curl, LDAP, Kerberos), which would cost every
/// start of the program.
struct MatioLibrary {
  decltype(&Mat_Open) open;
  decltype(&Mat_Close) close;
  decltype(&Mat_Rewind) rewind;
  decltype(&Mat_VarReadNextInfo) read_next_info;
  decltype(&Mat_VarReadInfo) read_info;
  decltype(&Mat_VarReadDataAll) read_data;
  decltype(&Mat_VarFree) free;
};

/// Throws InputError if the library is not installed.
const MatioLibrary& matio();

}  // namespace chasles
