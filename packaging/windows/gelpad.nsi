; The installer for one user, without administrator rights: gelpad, its start-menu entry, and an uninstaller.
; makensis -DVERSION=... -DSOURCE=FOLDER -DOUTPUT=FILE packaging/windows/gelpad.nsi
Target amd64-unicode
ManifestDPIAware true
RequestExecutionLevel user
SetCompressor /SOLID lzma
Name "gelpad ${VERSION}"
OutFile "${OUTPUT}"
InstallDir "$LOCALAPPDATA\Programs\gelpad"
InstallDirRegKey HKCU "Software\gelpad" "Folder"

!define UNINSTALL "Software\Microsoft\Windows\CurrentVersion\Uninstall\gelpad"

Page directory
Page instfiles
UninstPage uninstConfirm
UninstPage instfiles

Section "gelpad"
  SetOutPath "$INSTDIR"
  File /r "${SOURCE}/*.*"
  WriteUninstaller "$INSTDIR\uninstall.exe"
  CreateShortcut "$SMPROGRAMS\gelpad.lnk" "$INSTDIR\gelpad.exe"
  WriteRegStr HKCU "Software\gelpad" "Folder" "$INSTDIR"
  WriteRegStr HKCU "${UNINSTALL}" "DisplayName" "gelpad"
  WriteRegStr HKCU "${UNINSTALL}" "DisplayVersion" "${VERSION}"
  WriteRegStr HKCU "${UNINSTALL}" "UninstallString" '"$INSTDIR\uninstall.exe"'
  WriteRegDWORD HKCU "${UNINSTALL}" "NoModify" 1
  WriteRegDWORD HKCU "${UNINSTALL}" "NoRepair" 1
SectionEnd

Section "Uninstall"
  ; Only what was installed: recordings and profiles of the user lie elsewhere, and other files in the folder stay.
  Delete "$INSTDIR\gelpad.exe"
  Delete "$INSTDIR\README.md"
  Delete "$INSTDIR\CHANGELOG.md"
  Delete "$INSTDIR\windows.md"
  Delete "$INSTDIR\LICENSE-MIT.txt"
  Delete "$INSTDIR\LICENSE-APACHE.txt"
  Delete "$INSTDIR\profile.schema.json"
  Delete "$INSTDIR\gelpad.ps1"
  Delete "$INSTDIR\uninstall.exe"
  RMDir "$INSTDIR"
  Delete "$SMPROGRAMS\gelpad.lnk"
  DeleteRegKey HKCU "${UNINSTALL}"
  DeleteRegKey HKCU "Software\gelpad"
SectionEnd
