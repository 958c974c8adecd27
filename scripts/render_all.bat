@echo off
rem Renders the course's batch: seven scenes at 800 x 800, each as colour, normal and depth picture, 21 files in all.
rem
rem Usage: scripts\render_all.bat [OUTPUT_FOLDER]
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

call :render 01 scene01_plane 8 18 || exit /b 1
call :render 02 scene02_cube 8 18 || exit /b 1
call :render 03 scene03_sphere 8 18 || exit /b 1
call :render 04 scene04_axes 8 18 || exit /b 1
call :render 05 scene05_bunny_200 0.8 1.0 || exit /b 1
call :render 06 scene06_bunny_1k 8 18 -bounces 4 || exit /b 1
call :render 07 scene07_arch 8 18 -bounces 4 -shadows || exit /b 1
exit /b 0

:render
"%A2%" -input "%DATA%\%2.txt" -size %SIZE% %SIZE% -output "%output%\a%1.png" -normals "%output%\a%1n.png" -depth %3 %4 "%output%\a%1d.png" %5 %6 %7
exit /b %errorlevel%
