#!/usr/bin/env bash
# Draws docs/office.png, the picture of the README: a July day of `b2b run OfficeSmall`, from the page that the command
# writes. Needs `chromium` and `b2b` on the path, or other programs in B2B_BROWSER and B2B.
set -euo pipefail
cd "$(dirname "$0")"

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${B2B:-b2b}" run OfficeSmall --period 07-10..07-10 --out "$folder/run" > /dev/null
# Keeps the modes, the first zone, power and air flows; hides tables, buttons and the price, which is constant.
hidden='.pair, .bar, footer'
for panel in 3 4 5 6 7 9 11; do hidden+=", #panels > :nth-child($panel)"; done
sed "s|</style>|$hidden { display: none }</style>|" "$folder/run/picture.html" > "$folder/page.html"
"${B2B_BROWSER:-chromium}" --headless --no-sandbox --disable-gpu --hide-scrollbars --force-device-scale-factor=1.5 \
  --window-size=1200,1095 --virtual-time-budget=4000 --user-data-dir="$folder/profile" \
  --screenshot="$PWD/office.png" "file://$folder/page.html" 2> /dev/null
