@echo off
rem Renders the course's batch (data\batch.txt): seven scenes at 800 x 800, each as colour, normal and depth picture; and
rem the picture of anti-aliasing, a01aa.png: scene 01 with -jitter -filter, 144 rays a pixel, so at a quarter of the size.
rem
rem Usage: scripts\render_all.bat [OUTPUT_FOLDER]
rem A scene that fails does not stop the others; then the exit code is 1.
rem Environment: A2 (the program; default: built here), DATA (folder of the scenes; default: data), SIZE (default: 800).
setlocal
set "project=%~dp0.."
set "output=%~1"
if "%output%"=="" set "output=out"
if "%DATA%"=="" set "DATA=%project%\data"
if "%SIZE%"=="" set "SIZE=800"
if "%A2%"=="" (
    cargo build --release --quiet --manifest-path "%project%\Cargo.toml" || exit /b 1
    set "A2=%project%\target\release\a2.exe"
)
if not exist "%output%" mkdir "%output%"
set "failed=0"

for /f "usebackq eol=# tokens=1-4*" %%a in ("%project%\data\batch.txt") do (
    "%A2%" -input "%DATA%\%%b.txt" -size %SIZE% %SIZE% -output "%output%\a%%a.png" -normals "%output%\a%%an.png" -depth %%c %%d "%output%\a%%ad.png" %%e || set "failed=1"
)
set /a "quarter=SIZE / 4"
if %quarter% lss 1 set "quarter=1"
"%A2%" -input "%DATA%\scene01_plane.txt" -size %quarter% %quarter% -output "%output%\a01aa.png" -jitter -filter || set "failed=1"
exit /b %failed%
