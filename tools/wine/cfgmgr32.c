/* What Wine 8 lacks of Windows's library of this name and hidapi 0.13 cannot begin without: the list
   of the devices of a class, made of Wine's older functions, and a property of an interface, of
   which it says that there is none. hidapi then knows neither bus nor interface number. The rest
   goes on to Wine's own library. */
#define _CFGMGR32_ /* its functions are made here, not imported */
#include <windows.h>

#include <cfgmgr32.h>
#include <devpropdef.h>
#include <setupapi.h>
#include <stdlib.h>

/* Calls back with the path of each device that is there. */
static CONFIGRET each(const GUID *class, void (*take)(const wchar_t *, void *), void *what) {
  HDEVINFO all =
      SetupDiGetClassDevsW(class, NULL, NULL, DIGCF_PRESENT | DIGCF_DEVICEINTERFACE);
  if (all == INVALID_HANDLE_VALUE) return CR_FAILURE;
  SP_DEVICE_INTERFACE_DATA found = {.cbSize = sizeof found};
  for (DWORD i = 0; SetupDiEnumDeviceInterfaces(all, NULL, class, i, &found); ++i) {
    DWORD size = 0;
    SetupDiGetDeviceInterfaceDetailW(all, &found, NULL, 0, &size, NULL);
    SP_DEVICE_INTERFACE_DETAIL_DATA_W *detail = calloc(1, size);
    if (detail == NULL) break;
    detail->cbSize = sizeof *detail;
    if (SetupDiGetDeviceInterfaceDetailW(all, &found, detail, size, NULL, NULL)) {
      take(detail->DevicePath, what);
    }
    free(detail);
  }
  SetupDiDestroyDeviceInfoList(all);
  return CR_SUCCESS;
}

static void count(const wchar_t *path, void *length) {
  *(ULONG *)length += (ULONG)wcslen(path) + 1;
}

struct list {
  wchar_t *next;
  ULONG left;
  BOOL is_full;
};

static void append(const wchar_t *path, void *to) {
  struct list *list = to;
  const ULONG length = (ULONG)wcslen(path) + 1;
  if (length >= list->left) {
    list->is_full = TRUE;
    return;
  }
  wcscpy(list->next, path);
  list->next += length;
  list->left -= length;
}

CONFIGRET WINAPI CM_Get_Device_Interface_List_SizeW(
    PULONG length, LPGUID class, DEVINSTID_W device, ULONG flags) {
  (void)device;
  (void)flags;
  *length = 1; /* an empty string ends the list */
  return each(class, count, length);
}

CONFIGRET WINAPI CM_Get_Device_Interface_ListW(
    LPGUID class, DEVINSTID_W device, PZZWSTR buffer, ULONG length, ULONG flags) {
  (void)device;
  (void)flags;
  struct list list = {buffer, length, FALSE};
  const CONFIGRET result = each(class, append, &list);
  if (list.left > 0) *list.next = L'\0';
  return list.is_full ? CR_BUFFER_SMALL : result;
}

CONFIGRET WINAPI CM_Get_Device_Interface_PropertyW(
    LPCWSTR path, const DEVPROPKEY *key, DEVPROPTYPE *type, PBYTE buffer, PULONG size, ULONG flags) {
  (void)path;
  (void)key;
  (void)type;
  (void)buffer;
  (void)size;
  (void)flags;
  return CR_NO_SUCH_VALUE;
}
