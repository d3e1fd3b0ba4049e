/* What Wine 8 lacks and modules in Rust are linked to: the one function of Windows's library of this
   name. Another function, which Wine has, gives the random bytes. */
#include <windows.h>

BOOLEAN NTAPI SystemFunction036(void *, ULONG);

__declspec(dllexport) BOOL WINAPI ProcessPrng(unsigned char *data, SIZE_T size) {
  return SystemFunction036(data, (ULONG)size);
}
