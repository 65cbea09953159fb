; Copyright 2026 The OpenFab Authors
; SPDX-License-Identifier: Apache-2.0
;
; Of several patterns that match a node the last one counts.

(comment) @comment
(string) @string
(number) @number
(boolean) @boolean

["=" "+=" "-=" "*=" "/=" "%=" "&=" "|=" "^=" "<<=" ">>=" "+" "-" "*" "/" "%" "!" "~" "++" "--" "&&" "||" "&" "|" "^"
 "==" "!=" "<" ">" "<=" ">=" "<<" ">>"] @operator
["(" ")" "{" "}" "[" "]" "[["] @punctuation.bracket
["," ";" "." ":"] @punctuation.delimiter
(conditional ["?" ":"] @keyword.conditional.ternary)

["if" "else" "switch" "case" "default"] @keyword.conditional
["for" "while" "do"] @keyword.repeat
["return"] @keyword.return
["fablet" "struct" "enum"] @keyword.type
["import"] @keyword.import
(break) @keyword.repeat
(continue) @keyword.repeat
(qualifier) @keyword.modifier
(marker) @attribute
"@" @attribute

(identifier) @variable
(parameter (declarator name: (identifier) @variable.parameter))
(varying (declarator name: (identifier) @variable.parameter))
(field member: (field_identifier) @variable.member)
(member (declarator name: (identifier) @variable.member))
(uniform (declarator name: (identifier) @property))
(annotation name: (identifier) @property)

(type_identifier) @type
((type_identifier) @type.builtin
  (#any-of? @type.builtin "Material" "MaterialComposition" "Object" "ImageTexture2D" "ImageTexture3D" "Spline" "ColorRamp" "DitherAttributes" "GrowAttributes" "ShapeAttributes"
    "SurfaceAttributes" "SurfacePoint" "VolumeAttributes"))
(primitive_type) @type.builtin

(import module: (identifier) @module)
(fablet name: (identifier) @type.definition)
(struct name: (type_identifier) @type.definition)
(enum name: (type_identifier) @type.definition)
(enumerator name: (identifier) @constant)
(function name: (identifier) @function)
(call function: (identifier) @function.call)
(call function: (field member: (field_identifier) @function.method.call))
